#pragma once

#include <cstddef>
#include <vector>

namespace annulus {

/// The sum of many numbers of which a few change: the sum is that of a binary tree over all of them, so that it does
/// not depend on what was changed before, and its rounding error grows with the logarithm of their number. A change
/// costs that logarithm, too.
class PairwiseSum {
 public:
  /// Number `index` is 0 until it is set.
  void Set(std::size_t index, double value);
  [[nodiscard]] double Get(std::size_t index) const { return index < leaves_ ? tree_[leaves_ + index] : 0.0; }
  [[nodiscard]] double total() const { return leaves_ == 0 ? 0.0 : tree_[1]; }
  /// All numbers times a factor, and the sum with them.
  void Scale(double factor);

 private:
  void Grow(std::size_t count);

  std::size_t leaves_ = 0;    ///< A power of two, or 0.
  std::vector<double> tree_;  ///< Node i has the children 2i and 2i + 1; the root is node 1.
};

}  // namespace annulus
