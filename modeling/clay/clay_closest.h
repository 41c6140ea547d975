#pragma once

#include <Eigen/Core>

#include "modeling/clay/clay_body.h"

namespace annulus {

/// The address of the point of the skin nearest to `point`, found among all leaves: by their boxes, then by Newton in
/// the nearest of them. Right to 1e-9 mm where the nearest point is unique.
[[nodiscard]] ClayAddress ClosestAddress(const ClayBody& body, const Eigen::Vector3d& point);

}  // namespace annulus
