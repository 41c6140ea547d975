#pragma once

#include <Eigen/Core>

#include "modeling/measure/measured_surface.h"

namespace annulus {

/// P(theta, z) and its derivatives, station frame, mm and rad. by_theta × by_z points outward.
struct SurfaceDerivatives {
  Eigen::Vector3d position;
  Eigen::Vector3d by_theta;
  Eigen::Vector3d by_z;
  Eigen::Vector3d by_theta_theta;
  Eigen::Vector3d by_theta_z;
  Eigen::Vector3d by_z_z;
};

[[nodiscard]] SurfaceDerivatives DerivativesAt(const SplineSurface& surface, const SurfacePlace& place);

}  // namespace annulus
