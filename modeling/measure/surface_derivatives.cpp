#include "modeling/measure/surface_derivatives.h"

#include <cmath>

namespace annulus {

SurfaceDerivatives DerivativesAt(const SplineSurface& surface, const SurfacePlace& place) {
  const RadiusJet jet = surface.Jet(place.theta, place.z);
  // P = r e_r + z e_z; d e_r / d theta = e_t, d e_t / d theta = -e_r.
  const Eigen::Vector3d e_r(std::cos(place.theta), std::sin(place.theta), 0.0);
  const Eigen::Vector3d e_t(-e_r.y(), e_r.x(), 0.0);
  const Eigen::Vector3d e_z = Eigen::Vector3d::UnitZ();
  return {jet.r * e_r + place.z * e_z,
          jet.r_theta * e_r + jet.r * e_t,
          jet.r_z * e_r + e_z,
          (jet.r_theta_theta - jet.r) * e_r + 2.0 * jet.r_theta * e_t,
          jet.r_theta_z * e_r + jet.r_z * e_t,
          jet.r_z_z * e_r};
}

}  // namespace annulus
