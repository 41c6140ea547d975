#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/result.h"

namespace annulus {

/// How one range sensor sits in the ring and how its reading maps to a distance.
struct SensorCalibration {
  double theta = 0.0;            ///< rad; direction from the axis to the sensor.
  double radius_mm = 0.0;        ///< mm from the axis to the sensor's zero.
  double range_offset_mm = 0.0;  ///< mm added to the scaled reading.
  double range_scale = 1.0;      ///< factor on the reading.
  double aim_lateral = 0.0;      ///< rad; the beam turned about z, counter-clockwise seen from above positive.
  double aim_vertical = 0.0;     ///< rad; the beam raised from the horizontal.
  double height_mm = 0.0;        ///< mm; the sensor's height over the carriage's reference plane.
};

/// The value that turns raw ranges into points: one entry per sensor. Solving for it is fitting's business.
struct RingCalibration {
  std::string ring_serial;                 ///< The ring it belongs to; "" for an ideal ring.
  std::vector<SensorCalibration> sensors;  ///< Index = sensor number.

  /// An ideal ring: sensor i at theta_i = 2 pi i / count, radius R mm, aimed at the axis, no offset.
  /// Requires count >= 1 and radius_mm > 0.
  [[nodiscard]] static RingCalibration Ideal(double radius_mm, std::size_t count = 180);

  /// The beam of `sensor` with the carriage at height `carriage_z` mm, station frame.
  [[nodiscard]] Ray RayOf(std::size_t sensor, double carriage_z) const;

  /// The point seen by `sensor` at a raw range (mm) with the carriage at `carriage_z` (mm), station frame, mm.
  [[nodiscard]] Eigen::Vector3d PointOf(std::size_t sensor, double carriage_z, double raw_range_mm) const;
};

}  // namespace annulus
