#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "modeling/wrinkly/patch_grid.h"

namespace annulus {

/// What is to become of a cell.
struct CellChoice {
  enum class Kind : std::uint8_t {
    kCut,   ///< It is cut further.
    kKept,  ///< It becomes triangles.
    kGone,  ///< It is not seen.
  };
  Kind kind = Kind::kKept;
  float iterations = 0.0F;  ///< kKept: K of its values.
};

/// A node of a patch's tree of cells; its children are consecutive, column by column.
struct CellNode {
  std::int32_t children = -1;
  CellChoice choice{};
};

/// All cells that a surface is sampled by: one tree per patch. Chosen cell by cell without regard to neighbours.
class CellTrees {
 public:
  using Choose = std::function<CellChoice(const GridCell& cell)>;
  /// `choose` is called from several threads, for the cells of a patch in one. Cells stop being cut when there are more
  /// than `most` of them (see too_many) or a stop is requested.
  CellTrees(const PatchGrid& grid, const Choose& choose, std::size_t most, int threads, const std::stop_token& stop);

  [[nodiscard]] bool too_many() const { return leaves_ > most_; }
  /// Cells that are kept.
  [[nodiscard]] std::size_t kept() const { return leaves_; }
  /// Deepest and shallowest cell that is kept; 0 if none is.
  [[nodiscard]] int deepest() const { return deepest_; }
  [[nodiscard]] int shallowest() const { return shallowest_; }
  [[nodiscard]] const std::vector<CellNode>& Tree(PointIndex patch) const { return trees_[ControlMesh::Index(patch)]; }

  /// Calls visit(cell, choice) for every cell of a patch that is kept, in a fixed order.
  template <class Visit>
  void ForEachKept(PointIndex patch, Visit&& visit) const {
    if (!Tree(patch).empty()) Walk(patch, 0, {patch, 0, 0, 0}, visit);
  }

  /// Appends the corners of the cells that lie along a side of a cell, both ends left out, counter-clockwise along it,
  /// as {a, b} of the grid of depth `finest`; none if there is no such cell or it is not cut.
  void AddCornersAlong(const CellSide& side, int finest, std::vector<std::array<std::uint32_t, 2>>& corners) const;

 private:
  void Grow(PointIndex patch, const Choose& choose, const std::stop_token& stop);
  void AddBelow(std::size_t node, const CellSide& side, int finest,
                std::vector<std::array<std::uint32_t, 2>>& corners) const;

  template <class Visit>
  void Walk(PointIndex patch, std::size_t node, const GridCell& cell, Visit& visit) const {
    const CellNode& here = Tree(patch)[node];
    if (here.children < 0) {
      if (here.choice.kind == CellChoice::Kind::kKept) visit(cell, here.choice);
      return;
    }
    const auto cut = grid_->Cut(cell.depth);
    auto child = static_cast<std::size_t>(here.children);
    for (std::uint32_t a = 0; a < cut[0]; ++a) {
      for (std::uint32_t b = 0; b < cut[1]; ++b) {
        Walk(patch, child++, {patch, cell.depth + 1, cell.a * cut[0] + a, cell.b * cut[1] + b}, visit);
      }
    }
  }

  const PatchGrid* grid_;
  std::size_t most_;
  std::atomic<std::size_t> leaves_{0};
  int deepest_ = 0;
  int shallowest_ = 0;
  std::vector<std::vector<CellNode>> trees_;
};

}  // namespace annulus
