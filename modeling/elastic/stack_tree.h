#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fitting/front_store.h"
#include "modeling/elastic/solid_grid.h"

namespace annulus {

/// One step of the elimination: `own` unknowns leave the equations, those of the boundary are what they were coupled
/// to.
struct StackNode {
  FrontSize size;
  std::size_t first = 0;                       ///< Position of the first own unknown in the order; the others follow.
  std::vector<std::uint32_t> boundary;         ///< Positions, rising; all come later.
  std::vector<std::uint32_t> place_in_parent;  ///< Of each boundary unknown: own first, then boundary.
  std::vector<std::uint32_t> piles;            ///< Whose matrices enter here.
  std::size_t children = 0;                    ///< 0 … 2: the nodes just before, with theirs (postorder).
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
  /// Unknowns of a pile's matrix (StackCholesky::PileMatrix) in the front that it enters, rising there.
  [[nodiscard]] std::span<const FrontPlace> PlacesOf(std::size_t pile) const { return places_[pile]; }

 private:
  struct Part;
  class Boundaries;
  void Halve(const Part& part);
  void Own(const Part& line, std::size_t children);

  GridShape shape_;
  std::vector<StackNode> nodes_;
  std::vector<std::uint32_t> component_;
  std::vector<std::uint32_t> position_;          ///< By component; kHeld: none.
  std::vector<std::vector<FrontPlace>> places_;  ///< By pile.
};

}  // namespace annulus
