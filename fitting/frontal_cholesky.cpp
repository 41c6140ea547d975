#include "fitting/frontal_cholesky.h"

#include <algorithm>

#include "base/ensure.h"

namespace annulus {
namespace {

FrontSize SizeOf(const EliminationNode& node) { return {node.own_count, node.boundary_count}; }

/// Adds the leaves of a node without children.
class LeafAdder {
 public:
  LeafAdder(const EliminationTree& tree, const HierarchicalSpline& basis)
      : tree_(tree), basis_(basis), local_(basis.size(), 0) {}

  void Add(const EliminationNode& node, const FrontalCholesky::LeafMatrix& leaf_matrix, const Front& front) {
    const std::span<const std::uint32_t> boundary = tree_.Boundary(node);
    for (std::uint32_t k = 0; k < node.own_count; ++k) local_[node.own_first + k] = k;
    for (std::size_t k = 0; k < boundary.size(); ++k) {
      local_[boundary[k]] = node.own_count + static_cast<std::uint32_t>(k);
    }
    for (std::uint32_t k = 0; k < node.leaf_count; ++k) {
      const std::uint32_t leaf = tree_.leaf_order()[node.leaf_first + k];
      const FrontalCholesky::LeafView matrix = leaf_matrix(leaf);
      places_.clear();
      for (const std::uint32_t c : basis_.Active(basis_.leaves()[leaf])) {
        places_.push_back({local_[tree_.position()[c]], static_cast<std::uint32_t>(places_.size())});
      }
      std::sort(places_.begin(), places_.end(),
                [](const FrontPlace& a, const FrontPlace& b) { return a.in_front < b.in_front; });
      AddToFront(matrix.data, matrix.stride, places_, front);
    }
  }

 private:
  const EliminationTree& tree_;
  const HierarchicalSpline& basis_;
  std::vector<std::uint32_t> local_;  ///< Place in the front, by position.
  std::vector<FrontPlace> places_;    ///< Of one leaf's coefficients.
};

}  // namespace

FrontalCholesky::FrontalCholesky(std::shared_ptr<const EliminationTree> tree)
    : tree_(std::move(tree)), size_(static_cast<Eigen::Index>(tree_->position().size())) {
  std::vector<FrontSize> sizes;
  for (const EliminationNode& node : tree_->nodes()) {
    sizes.push_back(SizeOf(node));
    largest_boundary_ = std::max(largest_boundary_, static_cast<Eigen::Index>(node.boundary_count));
  }
  panels_ = FrontPanels(sizes);
}

template <class AddLeaves>
bool FrontalCholesky::Eliminate(AddLeaves add_leaves) {
  FrontStack stack;
  for (std::size_t n = 0; n < tree_->nodes().size(); ++n) {
    const EliminationNode& node = tree_->nodes()[n];
    const Front front{SizeOf(node), panels_[n], stack.Push(SizeOf(node))};
    if (node.left < 0) {
      add_leaves(node, front);
    } else {
      const EliminationNode& left = tree_->nodes()[static_cast<std::size_t>(node.left)];
      const EliminationNode& right = tree_->nodes()[static_cast<std::size_t>(node.right)];
      AddChildToFront(stack.FromTop(3), SizeOf(left), tree_->PlaceInParent(left), front);
      AddChildToFront(stack.FromTop(2), SizeOf(right), tree_->PlaceInParent(right), front);
    }
    if (!front.Eliminate()) return false;
    stack.DropBelowTop(node.left < 0 ? 0 : 2);
  }
  return true;
}

std::optional<FrontalCholesky> FrontalCholesky::Factor(std::shared_ptr<const EliminationTree> tree,
                                                       const HierarchicalSpline& basis, const LeafMatrix& leaf_matrix,
                                                       double ridge) {
  FrontalCholesky factor(std::move(tree));
  for (std::size_t n = 0; n < factor.tree_->nodes().size(); ++n) {
    const EliminationNode& node = factor.tree_->nodes()[n];
    for (std::size_t k = 0; k < node.own_count; ++k) factor.panels_[n][k * SizeOf(node).panel_stride() + k] = ridge;
  }
  LeafAdder leaves(*factor.tree_, basis);
  if (!factor.Eliminate(
          [&](const EliminationNode& node, const Front& front) { leaves.Add(node, leaf_matrix, front); })) {
    return std::nullopt;
  }
  return factor;
}

std::optional<FrontalCholesky> FrontalCholesky::Factor(std::shared_ptr<const EliminationTree> tree,
                                                       const Eigen::SparseMatrix<double>& upper) {
  FrontalCholesky factor(std::move(tree));
  const EliminationTree& order = *factor.tree_;
  if (upper.cols() != factor.size_ || upper.rows() != factor.size_) return std::nullopt;
  for (Eigen::Index column = 0; column < upper.cols(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(upper, column); entry; ++entry) {
      const auto [first, last] = std::minmax(order.position()[static_cast<std::size_t>(entry.row())],
                                             order.position()[static_cast<std::size_t>(column)]);
      const std::size_t n = order.owner()[first];
      const EliminationNode& node = order.nodes()[n];
      const std::optional<std::size_t> row = order.PlaceInFront(node, last);
      if (!row) return std::nullopt;
      factor.panels_[n][(first - node.own_first) * SizeOf(node).panel_stride() + *row] += entry.value();
    }
  }
  if (!factor.Eliminate([](const EliminationNode&, const Front&) {})) return std::nullopt;
  return factor;
}

FrontalCholesky::Columns FrontalCholesky::ColumnsOf(std::size_t n) const {
  const EliminationNode& node = tree_->nodes()[n];
  return {panels_[n], static_cast<Eigen::Index>(node.own_count + node.boundary_count),
          static_cast<Eigen::Index>(node.own_count),
          Eigen::OuterStride<>(static_cast<Eigen::Index>(SizeOf(node).panel_stride()))};
}

template <class Right>
Right FrontalCholesky::Lower(const Right& b) const {
  Right y(size_, b.cols());
  for (Eigen::Index c = 0; c < size_; ++c) y.row(tree_->position()[static_cast<std::size_t>(c)]) = b.row(c);
  Right scratch(largest_boundary_, b.cols());
  for (std::size_t n = 0; n < tree_->nodes().size(); ++n) {
    const EliminationNode& node = tree_->nodes()[n];
    const auto own = static_cast<Eigen::Index>(node.own_count);
    const auto boundary = static_cast<Eigen::Index>(node.boundary_count);
    auto inside = y.middleRows(static_cast<Eigen::Index>(node.own_first), own);
    auto below = scratch.topRows(boundary);
    below.setZero();
    for (Eigen::Index k = 0; k < own; ++k) {
      const double* column = panels_[n] + static_cast<std::size_t>(k) * SizeOf(node).panel_stride();
      inside.row(k) /= column[k];
      const Eigen::Map<const Eigen::VectorXd> own_part(column + k + 1, own - k - 1);
      const Eigen::Map<const Eigen::VectorXd> boundary_part(column + own, boundary);
      inside.bottomRows(own - k - 1).noalias() -= own_part.lazyProduct(inside.row(k));
      below.noalias() += boundary_part.lazyProduct(inside.row(k));
    }
    const std::span<const std::uint32_t> positions = tree_->Boundary(node);
    for (Eigen::Index k = 0; k < boundary; ++k) y.row(positions[static_cast<std::size_t>(k)]) -= below.row(k);
  }
  return y;
}

template <class Right>
Right FrontalCholesky::Upper(const Right& y) const {
  Right x = y;
  Right scratch(largest_boundary_, y.cols());
  for (std::size_t n = tree_->nodes().size(); n-- > 0;) {
    const EliminationNode& node = tree_->nodes()[n];
    const auto own = static_cast<Eigen::Index>(node.own_count);
    const std::span<const std::uint32_t> positions = tree_->Boundary(node);
    const auto boundary = static_cast<Eigen::Index>(positions.size());
    auto above = scratch.topRows(boundary);
    for (Eigen::Index k = 0; k < boundary; ++k) above.row(k) = x.row(positions[static_cast<std::size_t>(k)]);
    auto inside = x.middleRows(static_cast<Eigen::Index>(node.own_first), own);
    for (Eigen::Index k = own; k-- > 0;) {
      const double* column = panels_[n] + static_cast<std::size_t>(k) * SizeOf(node).panel_stride();
      const Eigen::Map<const Eigen::RowVectorXd> own_part(column + k + 1, own - k - 1);
      const Eigen::Map<const Eigen::RowVectorXd> boundary_part(column + own, boundary);
      inside.row(k) -= own_part.lazyProduct(inside.bottomRows(own - k - 1));
      inside.row(k) -= boundary_part.lazyProduct(above);
      inside.row(k) /= column[k];
    }
  }
  Right unordered(size_, y.cols());
  for (Eigen::Index c = 0; c < size_; ++c) unordered.row(c) = x.row(tree_->position()[static_cast<std::size_t>(c)]);
  return unordered;
}

Eigen::VectorXd FrontalCholesky::SolveLower(const Eigen::VectorXd& b) const { return Lower(b); }
FrontalCholesky::FourColumns FrontalCholesky::SolveLower(const FourColumns& b) const { return Lower(b); }
Eigen::VectorXd FrontalCholesky::SolveUpper(const Eigen::VectorXd& y) const { return Upper(y); }
Eigen::VectorXd FrontalCholesky::Solve(const Eigen::VectorXd& b) const { return Upper(Lower(b)); }
FrontalCholesky::FourColumns FrontalCholesky::Solve(const FourColumns& b) const { return Upper(Lower(b)); }

}  // namespace annulus
