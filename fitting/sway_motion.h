#pragma once

#include <Eigen/Core>
#include <cmath>

namespace annulus {

/// Height at which sway is stated, mm.
inline constexpr double kSwayHeight = 1000.0;

/// Ways in which a standing body moves as a whole: lean along x and y, yaw, shift along x and y.
inline constexpr Eigen::Index kSwayAxes = 5;
using SwayVector = Eigen::Matrix<double, kSwayAxes, 1>;
using SwayMatrix = Eigen::Matrix<double, kSwayAxes, kSwayAxes>;

/// How a standing body is displaced from its rest: turned about the ring's axis, leaned about the feet, and shifted.
struct SwayMotion {
  double lean_x = 0.0;   ///< mm at kSwayHeight, along +x; in proportion to the height elsewhere.
  double lean_y = 0.0;   ///< mm at kSwayHeight, along +y.
  double yaw = 0.0;      ///< rad, counter-clockwise seen from above.
  double shift_x = 0.0;  ///< mm along +x, the same at all heights: what is no lean about the feet.
  double shift_y = 0.0;  ///< mm along +y.

  [[nodiscard]] SwayVector Vector() const { return {lean_x, lean_y, yaw, shift_x, shift_y}; }
  /// Horizontal displacement of the axis at a height, mm.
  [[nodiscard]] Eigen::Vector2d At(double z) const {
    return {lean_x * z / kSwayHeight + shift_x, lean_y * z / kSwayHeight + shift_y};
  }
};

/// Where a point of the resting body (station frame, mm) is while the body is displaced. Leaning is the small rotation
/// that takes (0, 0, h) to (x, y, h): what is in front of the feet goes down as the body leans forward.
[[nodiscard]] inline Eigen::Vector3d StationFromRest(const Eigen::Vector3d& p_in_rest, const SwayMotion& motion) {
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  const Eigen::Vector2d turned(c * p_in_rest.x() - s * p_in_rest.y(), s * p_in_rest.x() + c * p_in_rest.y());
  const Eigen::Vector2d lean(motion.lean_x / kSwayHeight, motion.lean_y / kSwayHeight);
  Eigen::Vector3d p;
  p << turned + motion.At(p_in_rest.z()), p_in_rest.z() - lean.dot(turned);
  return p;
}

/// The inverse of StationFromRest, exactly.
[[nodiscard]] inline Eigen::Vector3d RestFromStation(const Eigen::Vector3d& p_in_station, const SwayMotion& motion) {
  const Eigen::Vector2d lean(motion.lean_x / kSwayHeight, motion.lean_y / kSwayHeight);
  const Eigen::Vector2d unshifted = p_in_station.head<2>() - Eigen::Vector2d(motion.shift_x, motion.shift_y);
  const double z = (p_in_station.z() + lean.dot(unshifted)) / (1.0 + lean.squaredNorm());
  const Eigen::Vector2d turned = unshifted - lean * z;
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  return {c * turned.x() + s * turned.y(), c * turned.y() - s * turned.x(), z};
}

}  // namespace annulus
