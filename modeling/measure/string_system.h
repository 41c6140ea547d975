#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace annulus {

/// A quadratic ½ cᵀHc - bᵀc of 3-vectors c_k in a row or ring: H has 3 × 3 blocks that couple neighbours only. Each
/// number is bounded by `low` <= 0 <= `high`; equal bounds fix it.
struct ChainSystem {
  std::vector<Eigen::Matrix3d> diagonal;
  std::vector<Eigen::Matrix3d> next;                 ///< Block (k, k + 1); one less than `diagonal`.
  Eigen::Matrix3d around = Eigen::Matrix3d::Zero();  ///< Block (0, last) of a ring; 0 in a row.
  std::vector<Eigen::Vector3d> right;                ///< b
  std::vector<Eigen::Vector3d> low;
  std::vector<Eigen::Vector3d> high;
};

/// H·c.
[[nodiscard]] std::vector<Eigen::Vector3d> Apply(const ChainSystem& system, const std::vector<Eigen::Vector3d>& c);

/// The solution of H·c = b without bounds, by elimination of blocks in O(blocks). Nothing if H is not positive
/// definite. Requires >= 3 blocks.
[[nodiscard]] std::optional<std::vector<Eigen::Vector3d>> SolveChain(const ChainSystem& system);

/// The minimum within the bounds by the primal-dual active set method (Hintermüller, Ito, Kunisch 2002): numbers
/// beyond a bound are fixed there, numbers that are fixed against their will are set free, until neither happens.
/// Where that goes round in circles the result is within the bounds but not the minimum. Nothing if H is not positive
/// definite on the free numbers. Requires >= 3 blocks.
[[nodiscard]] std::optional<std::vector<Eigen::Vector3d>> MinimiseChain(const ChainSystem& system);

}  // namespace annulus
