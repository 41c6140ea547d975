#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// A ball beside the fur: eyes and nose are data of their own, as in paper 003, fig. 14.
struct BearBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm
  double radius = 0.0;                               ///< mm
};

/// The furry bear of paper 003, fig. 14: a body with its head as one tube, and arms, legs, ears and a muzzle as tubes
/// that leave it by slits, at whose ends six patches meet; every tube ends in a ring net. Standing on z = 0, looking
/// along +y, 300 mm high. Attributes: height (the fur's length, mm), red, green, blue, opacity.
struct Bear {
  ControlMeshParts mesh;
  std::vector<BearBall> balls;
};
[[nodiscard]] Bear MakeBear(std::uint64_t seed);

}  // namespace annulus
