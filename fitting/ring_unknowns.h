#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/ring_calibration.h"

namespace annulus {

/// Distance at which angles and scales are stated in mm: about that of a waist from its sensor.
inline constexpr double kWorkingDistance = 450.0;

/// What is unknown of one sensor, as corrections of a starting calibration.
namespace sensor_unknown {
enum Index : int {
  kOffset,      ///< mm, of the distance at kWorkingDistance.
  kScale,       ///< mm per 100 mm of the reading.
  kRadial,      ///< mm outwards.
  kTangential,  ///< mm counter-clockwise; the beam keeps its direction.
  kHeight,      ///< mm upwards.
  kLateral,     ///< mm at kWorkingDistance: the beam turned about z.
  kVertical,    ///< mm at kWorkingDistance: the beam raised.
};
inline constexpr int kCount = 7;
}  // namespace sensor_unknown

/// What is unknown of the ring and the carriage as a whole.
namespace ring_unknown {
enum Index : int {
  kOffset,       ///< mm, common to all sensors, at kWorkingDistance.
  kScale,        ///< mm per 100 mm, common.
  kQuadratic,    ///< mm per (100 mm)^2, common.
  kTiltX,        ///< rad
  kTiltY,        ///< rad
  kHeightScale,  ///< mm/mm, of the reported height.
  kTemperature,  ///< mm per degree, common.
  kPitch,        ///< rad/mm; tilt about x that grows with the height. Its observability is computed, never its value.
  kRoll,         ///< rad/mm; about y. Likewise.
};
inline constexpr int kCount = 9;
}  // namespace ring_unknown

using SensorUnknowns = Eigen::Matrix<double, sensor_unknown::kCount, 1>;
using RingWideUnknowns = Eigen::Matrix<double, ring_unknown::kCount, 1>;

/// All corrections of a starting calibration.
struct RingUnknowns {
  std::vector<SensorUnknowns> sensors;
  RingWideUnknowns ring = RingWideUnknowns::Zero();
  std::vector<double> knots_z_mm;     ///< Of the carriage's path, ascending, station frame.
  std::vector<Eigen::Vector2d> path;  ///< mm; x and y at the knots.
};

/// Polynomial terms that the unknowns add to a distance: offset + scale * reading + quadratic * reading^2.
struct RangeTerms {
  double offset = 0.0, scale = 0.0, quadratic = 0.0;
};
[[nodiscard]] RangeTerms TermsOf(const SensorUnknowns& sensor, const RingWideUnknowns& ring);

/// The starting calibration with its corrections.
[[nodiscard]] RingCalibration Corrected(const RingCalibration& start, const RingUnknowns& unknowns);

/// Removes what no reading can show: the ring's centre (mean radial shift along x and y), a turn of the whole ring
/// (mean tangential shift), and a height common to all sensors. Station frame: the origin is the ring's centre and
/// sensor 0 and all others keep their mean direction.
void FixGauge(const RingCalibration& start, RingUnknowns& unknowns);

}  // namespace annulus
