#include "fitting/frontal_cholesky.h"

#include <algorithm>

#include "base/ensure.h"
#include "fitting/front_kernels.h"

namespace annulus {
namespace {

std::size_t RoundUp(std::size_t n) { return (n + kFrontLanes - 1) / kFrontLanes * kFrontLanes; }
std::size_t PanelStride(const EliminationNode& node) {
  return RoundUp(node.own_count + node.boundary_count) + kFrontLanes;
}
std::size_t RestStride(const EliminationNode& node) { return RoundUp(node.boundary_count) + kFrontLanes; }

/// A front: its first columns go to the factor, the rest to the parent. Local index: own first, then boundary.
struct Front {
  double* panel = nullptr;
  std::size_t panel_stride = 0;
  std::size_t own = 0;
  double* rest = nullptr;
  std::size_t rest_stride = 0;

  /// Requires row >= column.
  [[nodiscard]] double& At(std::size_t row, std::size_t column) const {
    return column < own ? panel[column * panel_stride + row] : rest[(column - own) * rest_stride + (row - own)];
  }
};

/// Schur complements that wait for their parents: the last two are the children of the node at hand (postorder).
class Stack {
 public:
  double* Push(std::size_t n) {
    starts_.push_back(used_);
    used_ += n;
    if (used_ > numbers_.size()) numbers_.resize(std::max(used_, 2 * numbers_.size()));
    std::fill_n(numbers_.begin() + static_cast<std::ptrdiff_t>(starts_.back()), n, 0.0);
    return numbers_.data() + starts_.back();
  }
  /// The n-th last.
  double* FromTop(std::size_t n) { return numbers_.data() + starts_[starts_.size() - n]; }
  /// Drops the `count` complements below the last one and moves that down.
  void DropBelowTop(std::size_t count) {
    if (count == 0) return;
    const std::size_t top = starts_.back();
    starts_.resize(starts_.size() - count);
    std::copy(numbers_.begin() + static_cast<std::ptrdiff_t>(top),
              numbers_.begin() + static_cast<std::ptrdiff_t>(used_),
              numbers_.begin() + static_cast<std::ptrdiff_t>(starts_.back()));
    used_ -= top - starts_.back();
  }

 private:
  std::vector<double> numbers_;
  std::vector<std::size_t> starts_;
  std::size_t used_ = 0;
};

void AddChild(const EliminationTree& tree, const EliminationNode& child, const double* rest, const Front& front) {
  const std::span<const std::uint32_t> place = tree.PlaceInParent(child);
  const std::size_t stride = RestStride(child);
  for (std::size_t c = 0; c < place.size(); ++c) {
    const double* from = rest + c * stride;
    double* column = &front.At(place[c], place[c]) - place[c];  // places ascend: rows below are in the same column
    for (std::size_t r = c; r < place.size(); ++r) column[place[r]] += from[r];
  }
}

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
      std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.in_front < b.in_front; });
      for (std::size_t b = 0; b < places_.size(); ++b) {
        double* column = &front.At(places_[b].in_front, places_[b].in_front) - places_[b].in_front;
        const double* from = matrix.data + places_[b].in_leaf * matrix.stride;
        for (std::size_t a = b; a < places_.size(); ++a) column[places_[a].in_front] += from[places_[a].in_leaf];
      }
    }
  }

 private:
  struct Place {
    std::uint32_t in_front = 0;
    std::uint32_t in_leaf = 0;
  };

  const EliminationTree& tree_;
  const HierarchicalSpline& basis_;
  std::vector<std::uint32_t> local_;  ///< Place in the front, by position.
  std::vector<Place> places_;         ///< Of one leaf's coefficients.
};

}  // namespace

FrontalCholesky::FrontalCholesky(std::shared_ptr<const EliminationTree> tree)
    : tree_(std::move(tree)), size_(static_cast<Eigen::Index>(tree_->position().size())) {
  std::size_t total = 0;
  for (const EliminationNode& node : tree_->nodes()) {
    panel_first_.push_back(total);
    total += PanelStride(node) * node.own_count;
    largest_boundary_ = std::max(largest_boundary_, static_cast<Eigen::Index>(node.boundary_count));
  }
  panels_.assign(total + kFrontLanes, 0.0);
}

template <class AddLeaves>
bool FrontalCholesky::Eliminate(AddLeaves add_leaves) {
  Stack stack;
  for (std::size_t n = 0; n < tree_->nodes().size(); ++n) {
    const EliminationNode& node = tree_->nodes()[n];
    double* rest = stack.Push(RestStride(node) * node.boundary_count + kFrontLanes);
    const Front front{Panel(n), PanelStride(node), node.own_count, rest, RestStride(node)};
    if (node.left < 0) {
      add_leaves(node, front);
    } else {
      AddChild(*tree_, tree_->nodes()[static_cast<std::size_t>(node.left)], stack.FromTop(3), front);
      AddChild(*tree_, tree_->nodes()[static_cast<std::size_t>(node.right)], stack.FromTop(2), front);
    }
    if (!EliminateFront(front.panel, front.panel_stride, node.own_count + node.boundary_count, node.own_count,
                        front.rest, front.rest_stride)) {
      return false;
    }
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
    for (std::size_t k = 0; k < node.own_count; ++k) factor.Panel(n)[k * PanelStride(node) + k] = ridge;
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
      factor.Panel(n)[(first - node.own_first) * PanelStride(node) + *row] += entry.value();
    }
  }
  if (!factor.Eliminate([](const EliminationNode&, const Front&) {})) return std::nullopt;
  return factor;
}

FrontalCholesky::Columns FrontalCholesky::ColumnsOf(std::size_t n) const {
  const EliminationNode& node = tree_->nodes()[n];
  return {Panel(n), static_cast<Eigen::Index>(node.own_count + node.boundary_count),
          static_cast<Eigen::Index>(node.own_count),
          Eigen::OuterStride<>(static_cast<Eigen::Index>(PanelStride(node)))};
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
      const double* column = Panel(n) + static_cast<std::size_t>(k) * PanelStride(node);
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
      const double* column = Panel(n) + static_cast<std::size_t>(k) * PanelStride(node);
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
