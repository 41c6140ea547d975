#include "modeling/elastic/stack_tree.h"

#include <algorithm>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

/// A part with no more stacks than this is not cut: its front is small enough to be eliminated at once.
constexpr std::size_t kSmallPart = 6;
constexpr std::uint32_t kHeld = std::numeric_limits<std::uint32_t>::max();

}  // namespace

/// A rectangle of stacks.
struct StackTree::Part {
  std::size_t i_min, i_max;  ///< Columns from i_min to before i_max.
  std::size_t j_min, j_max;

  [[nodiscard]] std::size_t width() const { return i_max - i_min; }
  [[nodiscard]] std::size_t height() const { return j_max - j_min; }
};

/// Finds for every node what its unknowns are coupled to, children before parents.
class StackTree::Boundaries {
 public:
  explicit Boundaries(StackTree& tree) : tree_(tree) {
    for (std::size_t n = 0; n < tree.nodes_.size(); ++n) owner_.insert(owner_.end(), tree.nodes_[n].size.own, n);
    tree.places_.resize(tree.shape_.piles());
    for (std::size_t pile = 0; pile < tree.shape_.piles(); ++pile) PlacePile(pile);
    for (std::size_t n = 0; n < tree.nodes_.size(); ++n) Collect(n);
  }

 private:
  /// A pile enters where its first unknown leaves; `in_front` is the position until that front is known.
  void PlacePile(std::size_t pile) {
    std::vector<FrontPlace>& places = tree_.places_[pile];
    const std::size_t per_stack = 3 * tree_.shape_.layers;
    const std::array<std::size_t, 4> stacks = tree_.shape_.StacksOf(pile);
    for (std::size_t k = 0; k < 4 * per_stack; ++k) {
      const std::uint32_t position = tree_.position_[stacks[k / per_stack] * per_stack + k % per_stack];
      if (position != kHeld) places.push_back({position, static_cast<std::uint32_t>(k)});
    }
    if (places.empty()) return;
    std::sort(places.begin(), places.end(),
              [](const FrontPlace& a, const FrontPlace& b) { return a.in_front < b.in_front; });
    tree_.nodes_[owner_[places.front().in_front]].piles.push_back(static_cast<std::uint32_t>(pile));
  }

  void Collect(std::size_t n) {
    StackNode& node = tree_.nodes_[n];
    const std::size_t end = node.first + node.size.own;
    std::vector<std::size_t> children;
    for (; children.size() < node.children; waiting_.pop_back()) children.push_back(waiting_.back());
    waiting_.push_back(n);
    const auto add = [&](std::uint32_t position) {
      if (position >= end) node.boundary.push_back(position);
    };
    for (const std::uint32_t pile : node.piles) {
      for (const FrontPlace& place : tree_.places_[pile]) add(place.in_front);
    }
    for (const std::size_t child : children) {
      for (const std::uint32_t position : tree_.nodes_[child].boundary) add(position);
    }
    std::sort(node.boundary.begin(), node.boundary.end());
    node.boundary.erase(std::unique(node.boundary.begin(), node.boundary.end()), node.boundary.end());
    node.size.boundary = node.boundary.size();
    const auto place_of = [&](std::uint32_t position) {
      if (position < end) return static_cast<std::uint32_t>(position - node.first);
      const auto at = std::lower_bound(node.boundary.begin(), node.boundary.end(), position);
      return static_cast<std::uint32_t>(node.size.own + static_cast<std::size_t>(at - node.boundary.begin()));
    };
    for (const std::size_t child : children) {
      for (const std::uint32_t position : tree_.nodes_[child].boundary) {
        tree_.nodes_[child].place_in_parent.push_back(place_of(position));
      }
    }
    for (const std::uint32_t pile : node.piles) {
      for (FrontPlace& place : tree_.places_[pile]) place.in_front = place_of(place.in_front);
    }
  }

  StackTree& tree_;
  std::vector<std::size_t> owner_;    ///< Node by position.
  std::vector<std::size_t> waiting_;  ///< Nodes whose parents are still to come.
};

StackTree::StackTree(const GridShape& shape, std::span<const char> held)
    : shape_(shape), position_(3 * shape.nodes(), kHeld) {
  ENSURE(held.size() == 3 * shape.nodes(), "every component is held or free");
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (held[k] == 0) position_[k] = 0;
  }
  if (shape.closure == GridClosure::kClosed) {
    Halve({1, shape.columns, 0, shape.rows});
    Own({0, 1, 0, shape.rows}, 1);  // the first column opens the ring
  } else {
    Halve({0, shape.columns, 0, shape.rows});
  }
  const Boundaries boundaries(*this);
}

void StackTree::Halve(const Part& part) {
  if (part.width() * part.height() <= kSmallPart || std::max(part.width(), part.height()) < 3) return Own(part, 0);
  Part line = part;
  Part below = part;
  Part above = part;
  if (part.width() >= part.height()) {
    line.i_min = below.i_max = part.i_min + part.width() / 2;
    line.i_max = above.i_min = line.i_min + 1;
  } else {
    line.j_min = below.j_max = part.j_min + part.height() / 2;
    line.j_max = above.j_min = line.j_min + 1;
  }
  Halve(below);
  Halve(above);
  Own(line, 2);
}

void StackTree::Own(const Part& line, std::size_t children) {
  StackNode node;
  node.first = component_.size();
  node.children = children;
  const std::size_t per_stack = 3 * shape_.layers;
  for (std::size_t j = line.j_min; j < line.j_max; ++j) {
    for (std::size_t i = line.i_min; i < line.i_max; ++i) {
      for (std::size_t k = 0; k < per_stack; ++k) {
        const std::size_t component = (j * shape_.columns + i) * per_stack + k;
        if (position_[component] == kHeld) continue;
        position_[component] = static_cast<std::uint32_t>(component_.size());
        component_.push_back(static_cast<std::uint32_t>(component));
      }
    }
  }
  node.size.own = component_.size() - node.first;
  nodes_.push_back(std::move(node));
}

}  // namespace annulus
