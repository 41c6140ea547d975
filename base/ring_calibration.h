#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/result.h"

namespace annulus {

/// How one range sensor sits in the ring and how its reading maps to a distance:
/// distance = range_offset_mm + range_scale * reading + range_quadratic * reading^2.
struct SensorCalibration {
  double theta = 0.0;            ///< rad; direction from the axis to the sensor.
  double radius_mm = 0.0;        ///< mm from the axis to the sensor's zero.
  double range_offset_mm = 0.0;  ///< mm added to the scaled reading.
  double range_scale = 1.0;      ///< factor on the reading, > 0.
  double aim_lateral = 0.0;      ///< rad; the beam turned about z, counter-clockwise seen from above positive.
  double aim_vertical = 0.0;     ///< rad; the beam raised from the horizontal.
  double height_mm = 0.0;        ///< mm; the sensor's height over the carriage's reference plane.
  double range_quadratic = 0.0;  ///< 1/mm; on the square of the reading.

  /// The distance along the beam, mm, for a reading, mm.
  [[nodiscard]] double Distance(double reading_mm) const {
    return range_offset_mm + (range_scale + range_quadratic * reading_mm) * reading_mm;
  }
  /// The reading, mm, for a distance, mm: the inverse of Distance near a scale of 1. NaN if there is none.
  [[nodiscard]] double ReadingOf(double distance_mm) const;

  bool operator==(const SensorCalibration&) const = default;
};

/// How the ring's own frame, in which its sensors are given, lies on the carriage.
struct RingPose {
  double x_mm = 0.0;    ///< Centre of the ring, station frame at the carriage's reference plane.
  double y_mm = 0.0;    ///< Likewise.
  double tilt_x = 0.0;  ///< rad; the ring's plane turned about x, right-handed: its front (+y) is raised.
  double tilt_y = 0.0;  ///< rad; then about y: its right (+x) is lowered.

  bool operator==(const RingPose&) const = default;
};

/// The carriage's way over the height that the drive reports: z = position_scale * reported; x and y linear between
/// knots, constant beyond them, plus slope times z.
struct CarriagePath {
  double position_scale = 1.0;     ///< mm/mm, > 0.
  double slope_x = 0.0;            ///< mm/mm; direction of the travel against station z.
  double slope_y = 0.0;            ///< mm/mm
  std::vector<double> knots_z_mm;  ///< Ascending, station frame; empty: straight.
  std::vector<double> x_mm;        ///< As many as knots.
  std::vector<double> y_mm;        ///< As many as knots.

  /// Where the carriage's reference point is when the drive reports a height (mm), station frame, mm.
  [[nodiscard]] Eigen::Vector3d At(double reported_z) const;

  bool operator==(const CarriagePath&) const = default;
};

/// What a calibration leaves unknown: the covariance (mm^2) of the sensors' effective radial errors
/// is diag(own_mm^2) + together_mm * together_mm^T, at `distance_mm` from the sensor.
struct CalibrationUncertainty {
  std::vector<double> own_mm;           ///< One per sensor: the part that each has for itself, >= 0.
  Eigen::MatrixXd together_mm;          ///< Sensors x modes: what they have together.
  double distance_mm = 450.0;           ///< mm; where it holds.
  double height_scale_sigma = 0.0;      ///< mm/mm; sd of position_scale.
  double height_offset_sigma_mm = 0.0;  ///< mm; sd of the error common to all heights.

  bool operator==(const CalibrationUncertainty&) const = default;
};

/// The value that turns raw ranges into points: one entry per sensor. Solving for it is fitting's business.
struct RingCalibration {
  std::string ring_serial;                 ///< The ring it belongs to; "" for an ideal ring.
  std::vector<SensorCalibration> sensors;  ///< Index = sensor number.
  RingPose pose;
  CarriagePath carriage;
  double reference_c = 20.0;    ///< Ring temperature at which the offsets hold, degrees Celsius.
  double range_mm_per_c = 0.0;  ///< mm by which all offsets rise per degree over it.
  std::string certificate;      ///< "sha256:..." of the calibration file that it came from; "" for an ideal ring.
  std::optional<CalibrationUncertainty> uncertainty{};  ///< Nothing: not known.

  /// An ideal ring: sensor i at theta_i = 2 pi i / count, radius R mm, aimed at the axis, no offset.
  /// Requires count >= 1 and radius_mm > 0.
  [[nodiscard]] static RingCalibration Ideal(double radius_mm, std::size_t count = 180);

  /// The beam of `sensor` when the drive reports the carriage at `carriage_z` mm, station frame.
  [[nodiscard]] Ray RayOf(std::size_t sensor, double carriage_z) const;

  /// The point seen by `sensor` at a raw range (mm) with the carriage reported at `carriage_z` (mm), station frame, mm.
  [[nodiscard]] Eigen::Vector3d PointOf(std::size_t sensor, double carriage_z, double raw_range_mm) const;

  /// The same with the offsets of a ring at `temperature_c`, which then is the reference.
  [[nodiscard]] RingCalibration AtTemperature(double temperature_c) const;

  /// Whether nothing but the seven numbers of each sensor differs from an ideal ring: what recordings knew before
  /// pose, carriage and quadratic terms.
  [[nodiscard]] bool IsPlain() const;
};

}  // namespace annulus
