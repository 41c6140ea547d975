#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "sim/parametric_body.h"

namespace annulus::test {

/// Distance from the ring's axis to the skin of a subject of one tube, mm. The ray from the axis meets the tube at the
/// angle phi about the tube's own centre that the ray's place there has: a fixed point, as the axis is near the centre.
inline double RadiusAboutAxis(const sim::ParametricBody& head, double theta, double z) {
  const sim::Placement& placement = head.placement();
  const Eigen::Vector2d own = head.torso().Centre(z);
  const Eigen::Vector2d centre = head.StationFromBody({own.x(), own.y(), z}).head<2>();
  const Eigen::Vector2d along(std::cos(theta), std::sin(theta));
  const double nearest = along.dot(centre);
  const double beside = along.x() * centre.y() - along.y() * centre.x();
  double reach = head.torso().Radius(theta - placement.yaw_rad, z);
  double t = 0.0;
  for (int k = 0; k < 40; ++k) {
    const double next = nearest + std::sqrt(std::max(reach * reach - beside * beside, 0.0));
    if (std::abs(next - t) < 1e-4) return next;
    t = next;
    const Eigen::Vector2d from_centre = t * along - centre;
    reach = head.torso().Radius(std::atan2(from_centre.y(), from_centre.x()) - placement.yaw_rad, z);
  }
  return t;
}

}  // namespace annulus::test
