#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/frames.h"

namespace annulus {

/// One calibrated return of one range sensor: a point that was seen, and along which ray. What the fitter takes.
/// Samples need not lie on a grid. A missing return is a missing sample.
struct SurfaceSample {
  double theta = 0.0;   ///< rad, [0, 2 pi), station frame.
  double z = 0.0;       ///< mm, station frame.
  double radius = 0.0;  ///< mm from the ring's axis; r = R - range for an ideal ring (paper 001, eq. 2.1).
  double time_s = 0.0;  ///< s since the first level of the scan; 0 where unknown (imported files).
  Eigen::Vector3f ray_direction = Eigen::Vector3f::Zero();  ///< Unit vector from sensor to surface, station frame.
  float weight = 1.0F;       ///< Relative weight >= 0 (return quality); 1 is an ordinary return.
  std::uint32_t level = 0;   ///< Level (row) of the scan, 0 is the first of its sweep.
  std::uint16_t sensor = 0;  ///< Sensor index on the ring, 0 … sensor_count - 1.
  std::uint16_t sweep = 0;   ///< Sweep of the scan, 0 is the first.

  /// The point in the station frame, mm.
  [[nodiscard]] Eigen::Vector3d Point() const { return PointFromCylindrical(theta, radius, z); }
};

}  // namespace annulus
