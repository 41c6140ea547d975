#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fitting/hierarchical_spline.h"

namespace annulus {

/// One step of the elimination: `own` coefficients leave the equations, `boundary` are those they were coupled to.
struct EliminationNode {
  std::uint32_t own_first = 0;  ///< Position of the first own coefficient in the order; the others follow.
  std::uint32_t own_count = 0;
  std::uint32_t boundary_first = 0;  ///< In the tree's pools.
  std::uint32_t boundary_count = 0;
  std::uint32_t leaf_first = 0;  ///< Spline leaves of the node's part of the surface, in the tree's leaf order.
  std::uint32_t leaf_count = 0;
  std::int32_t left = -1;  ///< Children (smaller numbers than their parent); -1: none.
  std::int32_t right = -1;
};

/// In which order the coefficients of a hierarchical spline are eliminated, by nested dissection (George 1973) of the
/// (theta, z) plane itself: the surface is halved again and again across its shorter way, and the coefficients that two
/// halves share are eliminated after those within. Nodes are in postorder, the root is the last. Immutable.
class EliminationTree {
 public:
  explicit EliminationTree(const HierarchicalSpline& basis);

  [[nodiscard]] const std::vector<EliminationNode>& nodes() const { return nodes_; }
  /// Position of every active coefficient in the order of elimination.
  [[nodiscard]] const std::vector<std::uint32_t>& position() const { return position_; }
  /// The node that owns each position.
  [[nodiscard]] const std::vector<std::uint32_t>& owner() const { return owner_; }
  /// Spline leaves in the order of the tree's parts.
  [[nodiscard]] const std::vector<std::uint32_t>& leaf_order() const { return leaf_order_; }
  /// Positions of a node's boundary coefficients, ascending; all come after its own.
  [[nodiscard]] std::span<const std::uint32_t> Boundary(const EliminationNode& node) const {
    return std::span(boundary_).subspan(node.boundary_first, node.boundary_count);
  }
  /// For each boundary coefficient its place in the parent's front (own first, then boundary).
  [[nodiscard]] std::span<const std::uint32_t> PlaceInParent(const EliminationNode& node) const {
    return std::span(place_in_parent_).subspan(node.boundary_first, node.boundary_count);
  }
  /// Place of a position in a node's front; nothing if it is not there.
  [[nodiscard]] std::optional<std::size_t> PlaceInFront(const EliminationNode& node, std::uint32_t position) const;

 private:
  struct Part;
  class Dissection;

  void NumberCoefficients(const HierarchicalSpline& basis);
  void CollectBoundaries(const HierarchicalSpline& basis);

  std::vector<EliminationNode> nodes_;
  std::vector<std::uint32_t> position_;
  std::vector<std::uint32_t> owner_;
  std::vector<std::uint32_t> leaf_order_;
  std::vector<std::uint32_t> boundary_;
  std::vector<std::uint32_t> place_in_parent_;
};

}  // namespace annulus
