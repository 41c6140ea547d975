#pragma once

#include <Eigen/Core>

namespace annulus::sim {

/// Value noise in [0, 1) over space: hashed at whole places, trilinear between. The same place, the same value.
[[nodiscard]] double SpaceNoise(const Eigen::Vector3d& place);

}  // namespace annulus::sim
