#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "modeling/elastic/solid_grid.h"

namespace annulus {

/// One step of the elimination: `own` unknowns leave the equations, `boundary` are those they were coupled to.
struct StackNode {
  std::vector<std::uint32_t> own;       ///< Stacks, in the order of elimination.
  std::vector<std::uint32_t> boundary;  ///< Stacks, in the order of elimination; all come later.
  std::vector<std::uint32_t> piles;     ///< Whose matrices enter here.
  std::vector<std::uint32_t> children;  ///< Nodes of smaller numbers, at most two.
  std::size_t own_count = 0;            ///< Unknowns.
  std::size_t boundary_count = 0;
  std::size_t first = 0;  ///< Position of the first own unknown in the order.
};

/// In which order the unknowns of a grid of stacks are eliminated, by nested dissection (George 1973): the grid is cut
/// again and again across its shorter way by a line of stacks, which is eliminated after the two sides. Nodes are in
/// postorder, the root is the last. Immutable.
class StackTree {
 public:
  /// `held`: 1 for each of the 3·nodes components that are given, not unknown.
  StackTree(const GridShape& shape, std::span<const char> held);

  [[nodiscard]] const GridShape& shape() const { return shape_; }
  [[nodiscard]] const std::vector<StackNode>& nodes() const { return nodes_; }
  /// Number of unknowns.
  [[nodiscard]] std::size_t size() const { return component_.size(); }
  /// Component 3·node + axis of each unknown, in the order of elimination.
  [[nodiscard]] const std::vector<std::uint32_t>& component() const { return component_; }
  /// Position of a stack's first unknown; its others follow, inner ones first.
  [[nodiscard]] std::size_t Position(std::size_t stack) const { return position_[stack]; }
  /// Components 0 … 3·layers − 1 of a stack that are unknown.
  [[nodiscard]] const std::vector<std::uint16_t>& Free(std::size_t stack) const { return free_[stack]; }

 private:
  struct Part;
  std::uint32_t Halve(const Part& part);
  void Number();
  void CollectBoundaries();

  GridShape shape_;
  std::vector<StackNode> nodes_;
  std::vector<std::vector<std::uint16_t>> free_;  ///< By stack.
  std::vector<std::size_t> position_;             ///< By stack.
  std::vector<std::uint32_t> component_;
};

}  // namespace annulus
