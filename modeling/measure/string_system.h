#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace annulus {

/// A symmetric linear system of 3 × 3 blocks that couple neighbours in a row and, in a ring, the last with the first.
struct ChainSystem {
  std::vector<Eigen::Matrix3d> diagonal;
  std::vector<Eigen::Matrix3d> next;                 ///< Block (k, k + 1); one less than `diagonal`.
  Eigen::Matrix3d around = Eigen::Matrix3d::Zero();  ///< Block (0, last) of a ring; 0 in a row.
  std::vector<Eigen::Vector3d> right;                ///< Right-hand side.
};

/// The solution with every diagonal block enlarged by `damping`·`scale[k]`, by block Cholesky in O(blocks). Nothing if
/// the matrix is not positive definite. Requires >= 3 blocks.
[[nodiscard]] std::optional<std::vector<Eigen::Vector3d>> SolveChain(const ChainSystem& system,
                                                                     const std::vector<Eigen::Matrix3d>& scale,
                                                                     double damping);

}  // namespace annulus
