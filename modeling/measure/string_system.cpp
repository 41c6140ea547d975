#include "modeling/measure/string_system.h"

#include <Eigen/LU>
#include <array>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Rounds in which numbers may be set free; after them they may only be fixed, which ends.
constexpr int kFreeRounds = 5;
constexpr int kRounds = 12;

/// Per number: free, or at which bound.
enum class Bound : char { kFree, kLow, kHigh };
using BoundsOfBlock = std::array<Bound, 3>;

/// Whether a symmetric block is positive definite, by its leading minors.
bool IsPositive(const Eigen::Matrix3d& block) {
  return block(0, 0) > 0.0 && block(0, 0) * block(1, 1) > block(0, 1) * block(1, 0) && block.determinant() > 0.0;
}

/// H restricted to the free numbers (1 on the diagonal of the others), and b less what the fixed ones bring in.
ChainSystem Restricted(const ChainSystem& system, const std::vector<BoundsOfBlock>& bounds) {
  const std::size_t count = system.diagonal.size();
  std::vector<Eigen::Vector3d> free(count, Eigen::Vector3d::Ones());
  std::vector<Eigen::Vector3d> fixed(count, Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (bounds[k][i] == Bound::kFree) continue;
      const auto at = static_cast<Eigen::Index>(i);
      free[k][at] = 0.0;
      fixed[k][at] = bounds[k][i] == Bound::kLow ? system.low[k][at] : system.high[k][at];
    }
  }
  ChainSystem restricted = system;
  const std::vector<Eigen::Vector3d> brought = Apply(system, fixed);
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d& keep = free[k];
    restricted.diagonal[k] = keep.asDiagonal() * system.diagonal[k] * keep.asDiagonal();
    restricted.diagonal[k].diagonal() += Eigen::Vector3d::Ones() - keep;
    restricted.right[k] = keep.cwiseProduct(system.right[k] - brought[k]) + fixed[k];
    if (k + 1 < count) restricted.next[k] = keep.asDiagonal() * system.next[k] * free[k + 1].asDiagonal();
  }
  restricted.around = free.front().asDiagonal() * system.around * free.back().asDiagonal();
  return restricted;
}

/// Whether numbers may be set free.
enum class Release { kAllowed, kForbidden };
/// `bounds` with what is beyond a bound fixed and, if allowed, what is drawn inwards free.
std::vector<BoundsOfBlock> Updated(const ChainSystem& system, const std::vector<Eigen::Vector3d>& c, Release release,
                                   std::vector<BoundsOfBlock> bounds) {
  const std::vector<Eigen::Vector3d> product = Apply(system, c);
  for (std::size_t k = 0; k < c.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      Bound& bound = bounds[k][i];
      if (bound == Bound::kFree) {
        if (c[k][at] < system.low[k][at]) bound = Bound::kLow;
        if (c[k][at] > system.high[k][at]) bound = Bound::kHigh;
      } else if (release == Release::kAllowed && system.low[k][at] < system.high[k][at]) {
        const double force = product[k][at] - system.right[k][at];  // of the bound on the number
        if (bound == Bound::kLow ? force < 0.0 : force > 0.0) bound = Bound::kFree;
      }
    }
  }
  return bounds;
}

}  // namespace

std::vector<Eigen::Vector3d> Apply(const ChainSystem& system, const std::vector<Eigen::Vector3d>& c) {
  const std::size_t count = c.size();
  std::vector<Eigen::Vector3d> product(count);
  for (std::size_t k = 0; k < count; ++k) product[k] = system.diagonal[k] * c[k];
  for (std::size_t k = 0; k + 1 < count; ++k) {
    product[k] += system.next[k] * c[k + 1];
    product[k + 1] += system.next[k].transpose() * c[k];
  }
  product.front() += system.around * c.back();
  product.back() += system.around.transpose() * c.front();
  return product;
}

std::optional<std::vector<Eigen::Vector3d>> SolveChain(const ChainSystem& system) {
  const std::size_t count = system.diagonal.size();
  ENSURE(count >= 3 && system.next.size() + 1 == count && system.right.size() == count,
         "a chain has three blocks or more and one coupling less");
  // Elimination from the front; a ring's fill is the column of the last block, `around`.
  const std::size_t last = count - 1;
  std::vector<Eigen::Matrix3d> inverse(count);
  std::vector<Eigen::Matrix3d> around(last);
  std::vector<Eigen::Vector3d> right = system.right;
  Eigen::Matrix3d block = system.diagonal[0];
  Eigen::Matrix3d fill = system.around;
  Eigen::Matrix3d last_block = system.diagonal[last];
  for (std::size_t k = 0; k < last; ++k) {
    if (k + 1 == last) fill += system.next[k];
    if (!IsPositive(block)) return std::nullopt;
    inverse[k] = block.inverse();
    around[k] = fill;
    const Eigen::Matrix3d inverse_fill = inverse[k] * fill;
    const Eigen::Vector3d inverse_right = inverse[k] * right[k];
    last_block -= fill.transpose() * inverse_fill;
    right[last] -= fill.transpose() * inverse_right;
    if (k + 1 == last) break;
    block = system.diagonal[k + 1] - system.next[k].transpose() * (inverse[k] * system.next[k]);
    right[k + 1] -= system.next[k].transpose() * inverse_right;
    fill = -system.next[k].transpose() * inverse_fill;
  }
  if (!IsPositive(last_block)) return std::nullopt;
  std::vector<Eigen::Vector3d> c(count);
  c[last] = last_block.inverse() * right[last];
  for (std::size_t k = last; k-- > 0;) {
    Eigen::Vector3d rest = right[k] - around[k] * c[last];
    if (k + 1 < last) rest -= system.next[k] * c[k + 1];
    c[k] = inverse[k] * rest;
  }
  return c;
}

std::optional<std::vector<Eigen::Vector3d>> MinimiseChain(const ChainSystem& system) {
  const std::size_t count = system.diagonal.size();
  ENSURE(system.low.size() == count && system.high.size() == count, "bounds for every block");
  // What stands at a bound is taken to stay there at first.
  std::vector<BoundsOfBlock> bounds(count, {Bound::kFree, Bound::kFree, Bound::kFree});
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      if (system.low[k][at] == 0.0 && (system.right[k][at] <= 0.0 || system.high[k][at] == 0.0)) {
        bounds[k][i] = Bound::kLow;
      } else if (system.high[k][at] == 0.0 && system.right[k][at] >= 0.0) {
        bounds[k][i] = Bound::kHigh;
      }
    }
  }
  std::optional<std::vector<Eigen::Vector3d>> c;
  for (int round = 0; round < kRounds; ++round) {
    c = SolveChain(Restricted(system, bounds));
    if (!c) return std::nullopt;
    std::vector<BoundsOfBlock> updated =
        Updated(system, *c, round < kFreeRounds ? Release::kAllowed : Release::kForbidden, bounds);
    if (updated == bounds) break;
    bounds = std::move(updated);
  }
  for (std::size_t k = 0; k < count; ++k) (*c)[k] = (*c)[k].cwiseMax(system.low[k]).cwiseMin(system.high[k]);
  return c;
}

}  // namespace annulus
