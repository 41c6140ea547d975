#include "modeling/clay/pairwise_sum.h"

#include <algorithm>

namespace annulus {

void PairwiseSum::Set(std::size_t index, double value) {
  if (index >= leaves_) Grow(index + 1);
  std::size_t node = leaves_ + index;
  tree_[node] = value;
  for (node /= 2; node > 0; node /= 2) tree_[node] = tree_[2 * node] + tree_[2 * node + 1];
}

void PairwiseSum::Scale(double factor) {
  for (std::size_t i = leaves_; i < tree_.size(); ++i) tree_[i] *= factor;
  for (std::size_t i = leaves_; i-- > 1;) tree_[i] = tree_[2 * i] + tree_[2 * i + 1];
}

void PairwiseSum::Grow(std::size_t count) {
  std::size_t leaves = std::max<std::size_t>(leaves_, 1);
  while (leaves < count) leaves *= 2;
  std::vector<double> tree(2 * leaves, 0.0);
  for (std::size_t i = 0; i < leaves_; ++i) tree[leaves + i] = tree_[leaves_ + i];
  for (std::size_t i = leaves; i-- > 1;) tree[i] = tree[2 * i] + tree[2 * i + 1];
  leaves_ = leaves;
  tree_ = std::move(tree);
}

}  // namespace annulus
