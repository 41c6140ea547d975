#include "fitting/elimination_tree.h"

#include <algorithm>
#include <limits>

namespace annulus {
namespace {

/// A part with no more spline leaves than this is not halved: its front is small enough to be eliminated at once.
constexpr std::size_t kSmallPart = 16;

}  // namespace

/// A rectangle of the surface in cells of the finest level, and its spline leaves.
struct EliminationTree::Part {
  std::uint32_t x_min = 0, x_max = 0;
  std::uint32_t y_min = 0, y_max = 0;
  std::size_t first = 0, last = 0;  ///< Range in the leaf order.
};

/// Halves the parts.
class EliminationTree::Dissection {
 public:
  Dissection(const HierarchicalSpline& basis, EliminationTree& tree)
      : tree_(tree), width_(static_cast<std::uint32_t>(basis.finest().theta_cells())) {
    const std::size_t top = basis.levels().size() - 1;
    for (const SplineLeaf& leaf : basis.leaves()) {
      const auto side = std::uint32_t{1} << (top - leaf.level);
      // Twice the centre, so that it stays whole.
      x_.push_back(2 * leaf.theta_cell * side + side);
      y_.push_back(2 * leaf.z_cell * side + side);
      tree_.leaf_order_.push_back(static_cast<std::uint32_t>(tree_.leaf_order_.size()));
    }
    const auto height = static_cast<std::uint32_t>(basis.finest().z_cells());
    coarse_ = std::uint32_t{1} << top;
    Halve({0, width_, 0, height, 0, tree_.leaf_order_.size()});
  }

 private:
  std::int32_t Halve(const Part& part) {
    EliminationNode node;
    node.leaf_first = static_cast<std::uint32_t>(part.first);
    node.leaf_count = static_cast<std::uint32_t>(part.last - part.first);
    if (part.last - part.first > kSmallPart) {
      // The whole circle is open at both ends of its cut.
      const std::uint32_t way_along_z = (part.y_max - part.y_min) * (part.x_max - part.x_min == width_ ? 2 : 1);
      const bool across_theta = way_along_z <= part.x_max - part.x_min;
      if (!Split(part, across_theta, node)) Split(part, !across_theta, node);
    }
    tree_.nodes_.push_back(node);
    return static_cast<std::int32_t>(tree_.nodes_.size()) - 1;
  }

  /// Cuts at the edge of a coarsest cell that has half of the leaves on either side, as far as one can.
  bool Split(const Part& part, bool across_theta, EliminationNode& node) {
    const std::vector<std::uint32_t>& at = across_theta ? x_ : y_;
    const std::uint32_t low = across_theta ? part.x_min : part.y_min;
    const std::uint32_t high = across_theta ? part.x_max : part.y_max;
    if (high - low < 2 * coarse_) return false;
    const auto begin = tree_.leaf_order_.begin();
    const auto first = begin + static_cast<std::ptrdiff_t>(part.first);
    const auto last = begin + static_cast<std::ptrdiff_t>(part.last);
    const auto middle = first + (last - first) / 2;
    std::nth_element(first, middle, last, [&](std::uint32_t a, std::uint32_t b) { return at[a] < at[b]; });
    const std::uint32_t median = at[*middle] / 2;
    const std::uint32_t cut = std::clamp((median + coarse_ / 2) / coarse_ * coarse_, low + coarse_, high - coarse_);
    const auto border = std::partition(first, last, [&](std::uint32_t leaf) { return at[leaf] < 2 * cut; });
    Part below = part;
    Part above = part;
    (across_theta ? below.x_max : below.y_max) = cut;
    (across_theta ? above.x_min : above.y_min) = cut;
    below.last = static_cast<std::size_t>(border - begin);
    above.first = below.last;
    node.left = Halve(below);
    node.right = Halve(above);
    return true;
  }

  EliminationTree& tree_;
  std::uint32_t width_;
  std::uint32_t coarse_ = 1;
  std::vector<std::uint32_t> x_;
  std::vector<std::uint32_t> y_;
};

EliminationTree::EliminationTree(const HierarchicalSpline& basis) {
  const Dissection dissection(basis, *this);
  NumberCoefficients(basis);
  CollectBoundaries(basis);
}

void EliminationTree::NumberCoefficients(const HierarchicalSpline& basis) {
  // A coefficient belongs to the smallest part that holds all leaves it shapes.
  std::vector<std::uint32_t> first(basis.size(), std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> last(basis.size(), 0);
  for (std::size_t k = 0; k < leaf_order_.size(); ++k) {
    const auto place = static_cast<std::uint32_t>(k);
    for (const std::uint32_t c : basis.Active(basis.leaves()[leaf_order_[k]])) {
      first[c] = std::min(first[c], place);
      last[c] = std::max(last[c], place);
    }
  }
  const auto holds = [&](std::int32_t n, std::size_t c) {
    if (n < 0) return false;
    const EliminationNode& node = nodes_[static_cast<std::size_t>(n)];
    return node.leaf_first <= first[c] && last[c] < node.leaf_first + node.leaf_count;
  };
  std::vector<std::uint32_t> owner(basis.size());
  for (std::size_t c = 0; c < basis.size(); ++c) {
    auto at = static_cast<std::int32_t>(nodes_.size()) - 1;
    for (;;) {
      const EliminationNode& node = nodes_[static_cast<std::size_t>(at)];
      const std::int32_t within = holds(node.left, c) ? node.left : holds(node.right, c) ? node.right : -1;
      if (within < 0) break;
      at = within;
    }
    owner[c] = static_cast<std::uint32_t>(at);
    ++nodes_[owner[c]].own_count;
  }
  std::uint32_t next = 0;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    nodes_[n].own_first = next;
    next += nodes_[n].own_count;
    owner_.insert(owner_.end(), nodes_[n].own_count, static_cast<std::uint32_t>(n));
  }
  std::vector<std::uint32_t> taken(nodes_.size(), 0);
  position_.resize(basis.size());
  for (std::size_t c = 0; c < basis.size(); ++c) position_[c] = nodes_[owner[c]].own_first + taken[owner[c]]++;
}

void EliminationTree::CollectBoundaries(const HierarchicalSpline& basis) {
  std::vector<std::uint32_t> union_of;
  for (EliminationNode& node : nodes_) {
    union_of.clear();
    const std::uint32_t own_end = node.own_first + node.own_count;
    if (node.left < 0) {
      for (std::uint32_t k = 0; k < node.leaf_count; ++k) {
        for (const std::uint32_t c : basis.Active(basis.leaves()[leaf_order_[node.leaf_first + k]])) {
          if (position_[c] >= own_end) union_of.push_back(position_[c]);
        }
      }
      std::sort(union_of.begin(), union_of.end());
      union_of.erase(std::unique(union_of.begin(), union_of.end()), union_of.end());
    } else {
      const auto left = Boundary(nodes_[static_cast<std::size_t>(node.left)]);
      const auto right = Boundary(nodes_[static_cast<std::size_t>(node.right)]);
      std::set_union(std::lower_bound(left.begin(), left.end(), own_end), left.end(),
                     std::lower_bound(right.begin(), right.end(), own_end), right.end(), std::back_inserter(union_of));
    }
    node.boundary_first = static_cast<std::uint32_t>(boundary_.size());
    node.boundary_count = static_cast<std::uint32_t>(union_of.size());
    boundary_.insert(boundary_.end(), union_of.begin(), union_of.end());
    place_in_parent_.resize(boundary_.size());
    for (const std::int32_t child : {node.left, node.right}) {
      if (child < 0) continue;
      const EliminationNode& below = nodes_[static_cast<std::size_t>(child)];
      std::size_t place = 0;
      for (std::uint32_t k = 0; k < below.boundary_count; ++k) {
        const std::uint32_t position = boundary_[below.boundary_first + k];
        if (position < own_end) {
          place_in_parent_[below.boundary_first + k] = position - node.own_first;
          continue;
        }
        while (union_of[place] != position) ++place;
        place_in_parent_[below.boundary_first + k] = node.own_count + static_cast<std::uint32_t>(place);
      }
    }
  }
}

std::optional<std::size_t> EliminationTree::PlaceInFront(const EliminationNode& node, std::uint32_t position) const {
  if (position < node.own_first) return std::nullopt;
  if (position < node.own_first + node.own_count) return position - node.own_first;
  const std::span<const std::uint32_t> boundary = Boundary(node);
  const auto found = std::lower_bound(boundary.begin(), boundary.end(), position);
  if (found == boundary.end() || *found != position) return std::nullopt;
  return node.own_count + static_cast<std::size_t>(found - boundary.begin());
}

}  // namespace annulus
