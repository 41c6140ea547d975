#pragma once

#include <Eigen/Core>
#include <cmath>

#include "base/units.h"

namespace annulus {

/// Station frame: mm, right-handed, origin on the ring's axis at floor level, z up, +x the subject's right,
/// +y the subject's front. Cylindrical theta is from +x counter-clockwise seen from above (front = 90 degrees).

/// `theta` brought into [0, 2 pi), rad. Any finite input.
inline double WrapAngle(double theta) {
  if (theta >= 0.0 && theta < kTwoPi) return theta;  // as it mostly is; the remainder is dear
  const double wrapped = std::fmod(theta, kTwoPi);
  const double positive = wrapped < 0.0 ? wrapped + kTwoPi : wrapped;
  return positive < kTwoPi ? positive : 0.0;
}

/// The signed difference a - b brought into [-pi, pi), rad.
inline double AngleDifference(double a, double b) { return WrapAngle(a - b + kPi) - kPi; }

/// The point of the station frame (mm) at cylindrical coordinates.
inline Eigen::Vector3d PointFromCylindrical(double theta, double radius, double z) {
  return {radius * std::cos(theta), radius * std::sin(theta), z};
}

/// A half line. `direction` has unit length; both in the station frame, origin in mm.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

}  // namespace annulus
