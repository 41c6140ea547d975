#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/parametric_body.h"

namespace annulus::test {

/// A simulated head as it is, not as any fit sees it: inside and distances by looking at its own shape densely.
class TrueHead {
 public:
  explicit TrueHead(const sim::ParametricBody& body) : body_(body) {}

  /// How far a point lies outward of the skin along its section's ray, mm; negative inside. Station frame.
  [[nodiscard]] double RadialGap(const Eigen::Vector3d& p_in_station) const {
    const Eigen::Vector3d p = BodyFromStation(p_in_station);
    if (p.z() <= body_.torso().z_min() || p.z() >= body_.torso().z_max()) return kFar;
    const Eigen::Vector2d off = p.head<2>() - body_.torso().Centre(p.z());
    return off.norm() - body_.torso().Radius(std::atan2(off.y(), off.x()), p.z());
  }

  /// The signed distance, mm: the least to a net of points about the radial foot, three times made finer. Farther than
  /// `reach` mm along the ray the radial gap itself is given.
  [[nodiscard]] double Distance(const Eigen::Vector3d& p_in_station, double reach) const {
    const double gap = RadialGap(p_in_station);
    if (std::abs(gap) > reach) return gap;
    const Eigen::Vector3d p = BodyFromStation(p_in_station);
    const Eigen::Vector2d off = p.head<2>() - body_.torso().Centre(p.z());
    const double radius = off.norm();
    double theta = std::atan2(off.y(), off.x());
    double z = p.z();
    double half = std::abs(gap) + 0.5;
    double least = kFar;
    for (int round = 0; round < 4; ++round) {
      constexpr int kHalfNet = 10;
      const double middle_theta = theta;
      const double middle_z = z;
      for (int i = -kHalfNet; i <= kHalfNet; ++i) {
        for (int j = -kHalfNet; j <= kHalfNet; ++j) {
          const double there_theta = middle_theta + i * half / kHalfNet / radius;
          const double there_z = middle_z + j * half / kHalfNet;
          const double distance = (body_.torso().Point(there_theta, there_z) - p).norm();
          if (distance >= least) continue;
          least = distance;
          theta = there_theta;
          z = there_z;
        }
      }
      half *= 0.2;
    }
    return gap < 0.0 ? -least : least;
  }

 private:
  static constexpr double kFar = 1e3;
  [[nodiscard]] Eigen::Vector3d BodyFromStation(const Eigen::Vector3d& p) const {
    const sim::Placement& at = body_.placement();
    const Eigen::Vector3d moved(p.x() - at.x_mm, p.y() - at.y_mm, p.z());
    return Eigen::AngleAxisd(-at.yaw_rad, Eigen::Vector3d::UnitZ()) * moved;
  }
  const sim::ParametricBody& body_;
};

}  // namespace annulus::test
