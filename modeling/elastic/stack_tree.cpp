#include "modeling/elastic/stack_tree.h"

#include <algorithm>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

/// A part with no more stacks than this is not cut: its front is small enough to be eliminated at once.
constexpr std::size_t kSmallPart = 6;

}  // namespace

/// A rectangle of stacks.
struct StackTree::Part {
  std::size_t i_min, i_max;  ///< Columns from i_min to before i_max.
  std::size_t j_min, j_max;

  [[nodiscard]] std::size_t width() const { return i_max - i_min; }
  [[nodiscard]] std::size_t height() const { return j_max - j_min; }
};

StackTree::StackTree(const GridShape& shape, std::span<const char> held) : shape_(shape) {
  ENSURE(held.size() == 3 * shape.nodes(), "every component is held or free");
  const std::size_t per_stack = 3 * shape.layers;
  free_.resize(shape.stacks());
  for (std::size_t stack = 0; stack < shape.stacks(); ++stack) {
    for (std::size_t k = 0; k < per_stack; ++k) {
      if (held[stack * per_stack + k] == 0) free_[stack].push_back(static_cast<std::uint16_t>(k));
    }
  }
  if (shape.closure == GridClosure::kClosed) {
    // The first column opens the ring.
    const std::uint32_t rest = Halve({1, shape.columns, 0, shape.rows});
    StackNode node;
    for (std::size_t j = 0; j < shape.rows; ++j) node.own.push_back(static_cast<std::uint32_t>(j * shape.columns));
    node.children = {rest};
    nodes_.push_back(std::move(node));
  } else {
    Halve({0, shape.columns, 0, shape.rows});
  }
  Number();
  CollectBoundaries();
}

std::uint32_t StackTree::Halve(const Part& part) {
  StackNode node;
  Part line = part;
  if (part.width() * part.height() > kSmallPart && std::max(part.width(), part.height()) >= 3) {
    Part below = part;
    Part above = part;
    if (part.width() >= part.height()) {
      line.i_min = below.i_max = part.i_min + part.width() / 2;
      line.i_max = above.i_min = line.i_min + 1;
    } else {
      line.j_min = below.j_max = part.j_min + part.height() / 2;
      line.j_max = above.j_min = line.j_min + 1;
    }
    node.children.push_back(Halve(below));
    node.children.push_back(Halve(above));
  }
  for (std::size_t j = line.j_min; j < line.j_max; ++j) {
    for (std::size_t i = line.i_min; i < line.i_max; ++i) {
      node.own.push_back(static_cast<std::uint32_t>(j * shape_.columns + i));
    }
  }
  nodes_.push_back(std::move(node));
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void StackTree::Number() {
  position_.resize(shape_.stacks());
  const auto per_stack = static_cast<std::uint32_t>(3 * shape_.layers);
  for (StackNode& node : nodes_) {
    node.first = component_.size();
    for (const std::uint32_t stack : node.own) {
      position_[stack] = component_.size();
      for (const std::uint16_t k : free_[stack]) component_.push_back(stack * per_stack + k);
    }
    node.own_count = component_.size() - node.first;
  }
}

void StackTree::CollectBoundaries() {
  std::vector<std::uint32_t> rank(shape_.stacks());  // in the order of elimination
  std::vector<std::uint32_t> owner(shape_.stacks());
  std::vector<std::uint32_t> last(nodes_.size());
  std::uint32_t next = 0;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    for (const std::uint32_t stack : nodes_[n].own) {
      rank[stack] = next++;
      owner[stack] = static_cast<std::uint32_t>(n);
    }
    last[n] = next;
  }
  std::vector<std::vector<std::uint32_t>> around(nodes_.size());
  for (std::size_t pile = 0; pile < shape_.piles(); ++pile) {
    const std::array<std::size_t, 4> stacks = shape_.StacksOf(pile);
    const std::size_t first =
        *std::min_element(stacks.begin(), stacks.end(), [&](auto a, auto b) { return rank[a] < rank[b]; });
    nodes_[owner[first]].piles.push_back(static_cast<std::uint32_t>(pile));
    for (const std::size_t stack : stacks) around[owner[first]].push_back(static_cast<std::uint32_t>(stack));
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    StackNode& node = nodes_[n];
    std::vector<std::uint32_t> candidates = std::move(around[n]);
    for (const std::uint32_t child : node.children) {
      const std::vector<std::uint32_t>& more = nodes_[child].boundary;
      candidates.insert(candidates.end(), more.begin(), more.end());
    }
    std::sort(candidates.begin(), candidates.end(), [&](auto a, auto b) { return rank[a] < rank[b]; });
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    for (const std::uint32_t stack : candidates) {
      if (rank[stack] < last[n] || free_[stack].empty()) continue;
      node.boundary.push_back(stack);
      node.boundary_count += free_[stack].size();
    }
  }
}

}  // namespace annulus
