#include "modeling/measure/string_system.h"

#include <Eigen/Cholesky>

#include "base/ensure.h"

namespace annulus {

std::optional<std::vector<Eigen::Vector3d>> SolveChain(const ChainSystem& system,
                                                       const std::vector<Eigen::Matrix3d>& scale, double damping) {
  const std::size_t count = system.diagonal.size();
  ENSURE(count >= 3 && system.next.size() + 1 == count && system.right.size() == count && scale.size() == count,
         "a chain has three blocks or more and one coupling less");
  // Elimination from the front; a ring's fill is the column of the last block, `around`.
  const std::size_t last = count - 1;
  std::vector<Eigen::LLT<Eigen::Matrix3d>> factor(count);
  std::vector<Eigen::Matrix3d> around(last);
  std::vector<Eigen::Vector3d> right = system.right;
  Eigen::Matrix3d block = system.diagonal[0] + damping * scale[0];
  Eigen::Matrix3d fill = system.around;
  Eigen::Matrix3d last_block = system.diagonal[last] + damping * scale[last];
  for (std::size_t k = 0; k < last; ++k) {
    if (k + 1 == last) fill += system.next[k];
    factor[k].compute(block);
    if (factor[k].info() != Eigen::Success) return std::nullopt;
    around[k] = fill;
    const Eigen::Matrix3d inverse_fill = factor[k].solve(fill);
    const Eigen::Vector3d inverse_right = factor[k].solve(right[k]);
    last_block -= fill.transpose() * inverse_fill;
    right[last] -= fill.transpose() * inverse_right;
    if (k + 1 == last) break;
    const Eigen::Matrix3d inverse_next = factor[k].solve(system.next[k]);
    block = system.diagonal[k + 1] + damping * scale[k + 1] - system.next[k].transpose() * inverse_next;
    right[k + 1] -= system.next[k].transpose() * inverse_right;
    fill = -system.next[k].transpose() * inverse_fill;
  }
  factor[last].compute(last_block);
  if (factor[last].info() != Eigen::Success) return std::nullopt;
  std::vector<Eigen::Vector3d> x(count);
  x[last] = factor[last].solve(right[last]);
  for (std::size_t k = last; k-- > 0;) {
    Eigen::Vector3d rest = right[k] - around[k] * x[last];
    if (k + 1 < last) rest -= system.next[k] * x[k + 1];
    x[k] = factor[k].solve(rest);
  }
  return x;
}

}  // namespace annulus
