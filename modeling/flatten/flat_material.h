#pragma once

#include <Eigen/Core>

#include "base/result.h"

namespace annulus {

/// A sheet of cloth as an elastic body in plane stress, its threads along the axes of the flat piece: the warp along y
/// (the grain line), the weft along x. The strain that it is applied to is (flat length − length on the body) / length
/// on the body.
struct FlatMaterial {
  double e_warp = 1.0;        ///< Young's modulus along the warp, N/mm², > 0.
  double e_weft = 1.0;        ///< Across it, > 0.
  double poisson = 0.3;       ///< How much a pull along the warp narrows the weft; poisson² · e_weft < e_warp.
  double shear = 0.0;         ///< G, N/mm²; 0 stands for the isotropic e / (2 (1 + poisson)) of the mean modulus.
  double thickness_mm = 1.0;  ///< > 0
};

/// Stress resultants, N/mm, per strain (weft, warp, shear angle): symmetric, positive definite. Requires a material
/// that CheckMaterial accepts.
[[nodiscard]] Eigen::Matrix3d Stiffness(const FlatMaterial& material);

/// Fails on moduli, Poisson's ratio or thickness without a positive energy.
[[nodiscard]] Status CheckMaterial(const FlatMaterial& material);

}  // namespace annulus
