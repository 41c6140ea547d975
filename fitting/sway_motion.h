#pragma once

#include <Eigen/Core>
#include <cmath>

namespace annulus {

/// Height at which sway is stated, mm.
inline constexpr double kSwayHeight = 1000.0;

/// How a standing body is displaced from its rest: turned about the ring's axis, then leaned about the feet.
struct SwayMotion {
  double x = 0.0;    ///< mm at kSwayHeight, along +x; in proportion to the height elsewhere.
  double y = 0.0;    ///< mm at kSwayHeight, along +y.
  double yaw = 0.0;  ///< rad, counter-clockwise seen from above.

  [[nodiscard]] Eigen::Vector3d Vector() const { return {x, y, yaw}; }
};

/// Where a point of the resting body (station frame, mm) is while the body is displaced. Leaning is the small rotation
/// that takes (0, 0, h) to (x, y, h): what is in front of the feet goes down as the body leans forward.
[[nodiscard]] inline Eigen::Vector3d StationFromRest(const Eigen::Vector3d& p_in_rest, const SwayMotion& motion) {
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  const Eigen::Vector2d turned(c * p_in_rest.x() - s * p_in_rest.y(), s * p_in_rest.x() + c * p_in_rest.y());
  const Eigen::Vector2d lean(motion.x / kSwayHeight, motion.y / kSwayHeight);
  Eigen::Vector3d p;
  p << turned + lean * p_in_rest.z(), p_in_rest.z() - lean.dot(turned);
  return p;
}

/// The inverse of StationFromRest, exactly.
[[nodiscard]] inline Eigen::Vector3d RestFromStation(const Eigen::Vector3d& p_in_station, const SwayMotion& motion) {
  const Eigen::Vector2d lean(motion.x / kSwayHeight, motion.y / kSwayHeight);
  const double z = (p_in_station.z() + lean.dot(p_in_station.head<2>())) / (1.0 + lean.squaredNorm());
  const Eigen::Vector2d turned = p_in_station.head<2>() - lean * z;
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  return {c * turned.x() + s * turned.y(), c * turned.y() - s * turned.x(), z};
}

}  // namespace annulus
