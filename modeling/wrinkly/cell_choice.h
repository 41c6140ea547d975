#pragma once

#include "modeling/wrinkly/cell_trees.h"
#include "modeling/wrinkly/sample_surface.h"

namespace annulus {

/// Cuts every cell to a depth.
[[nodiscard]] CellTrees::Choose EvenCells(double iterations, int depth);

/// Cuts cells by their size on a screen (SamplingOptions::view). Of cells whose sides are between 1/n of the limit and
/// the limit, n being the parts that a side is cut into, a share is cut that grows with the size from none to all, so
/// that the number of cells per area stays what it is where the longest just keep the limit; which ones, an ordered
/// dither says, which is the same in every picture. K = depth + log_n(size / limit). Borrows the grid.
[[nodiscard]] CellTrees::Choose CellsOnScreen(const PatchGrid& grid, const SamplingOptions& options);

}  // namespace annulus
