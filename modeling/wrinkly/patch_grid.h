#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "modeling/wrinkly/control_mesh.h"
#include "modeling/wrinkly/mesh_shuffle.h"
#include "modeling/wrinkly/wrinkly_surface.h"

namespace annulus {

/// A cell of a patch: one part of the grid that `depth` subdivisions make of it. Rows and columns count in the patch's
/// right-handed frame: a along U from its − to its + side, b a quarter turn counter-clockwise of it, seen from outside.
struct GridCell {
  PointIndex patch = 0;
  int depth = 0;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
};

/// A corner of cells, by the finest grid: the same point of the surface has the same key whatever cell it is seen from.
struct CornerKey {
  std::uint64_t what = 0;   ///< A patch's inside, one of its sides, or a cell of the control mesh; and which.
  std::uint64_t where = 0;  ///< Steps along both, or along the side.
  bool operator==(const CornerKey&) const = default;
};

/// One side of a grid cell as the neighbouring patch has it.
struct CellSide {
  GridCell cell;
  std::size_t side = 0;  ///< Which side of that cell: 0 … 3 are +a, +b, −a, −b.
};

/// The nested grids on which a wrinkly surface is sampled: cell of depth d is cut into as many parts as iteration d of
/// the surface deals out, or into 3 × 3 where a family does not shuffle (M = 0), so that a smallest cell of K
/// iterations is a cell of depth K. Borrows the surface. Thread-safe.
class PatchGrid {
 public:
  /// Requires finest <= MostDepth(surface).
  PatchGrid(const WrinklySurface& surface, int finest);
  /// The most subdivisions whose cells can be counted.
  static int MostDepth(const WrinklySurface& surface);

  [[nodiscard]] const WrinklySurface& surface() const { return *surface_; }
  [[nodiscard]] int finest() const { return finest_; }
  /// Into how many columns and rows a cell of this depth is cut.
  [[nodiscard]] std::array<std::uint32_t, 2> Cut(int depth) const;
  /// Columns and rows of a patch at a depth.
  [[nodiscard]] const std::array<std::uint32_t, 2>& Parts(int depth) const {
    return parts_[static_cast<std::size_t>(depth)];
  }

  /// The cell of the same depth across a side, and which of its sides that is. Empty (side 4): there is none.
  [[nodiscard]] CellSide Across(const GridCell& cell, std::size_t side) const;
  /// The point of the finest grid `a`, `b` (0 … parts) steps from a patch's first corner.
  [[nodiscard]] CornerKey KeyOf(PointIndex patch, std::uint32_t a, std::uint32_t b) const;

  /// Where in the parameter domain a fraction of a cell lies: u, v in 0 … 1 of the patch.
  [[nodiscard]] std::array<double, 2> Parameters(const GridCell& cell, double in_a, double in_b) const;
  /// The same as a place that Values takes, on the grid of cell.depth iterations.
  [[nodiscard]] MeshPlace PlaceOf(const GridCell& cell, double in_a, double in_b) const;

 private:
  /// Steps along a side, counter-clockwise, of a point or cell that lies on it; `most` = parts (points), parts − 1
  /// (cells).
  static std::uint32_t Along(std::size_t side, std::array<std::uint32_t, 2> at, std::array<std::uint32_t, 2> most);

  const WrinklySurface* surface_;
  int finest_;
  std::vector<std::array<std::uint32_t, 2>> parts_;  ///< By depth.
};

}  // namespace annulus
