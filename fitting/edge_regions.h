#pragma once

#include <cstddef>
#include <vector>

#include "fitting/cell_grid.h"

namespace annulus {

/// A connected set of cells where the smoothing is broken because the data step or bend sharply.
struct EdgeRegion {
  double theta_from = 0.0;  ///< rad, the region runs counter-clockwise from here …
  double theta_to = 0.0;    ///< … to here; may be beyond 2 pi.
  double z_min = 0.0;       ///< mm
  double z_max = 0.0;
  std::size_t cells = 0;
};

/// The connected regions (8 neighbours, cyclic in theta) of at least four flagged cells, largest first, 50 at most.
[[nodiscard]] std::vector<EdgeRegion> FindEdgeRegions(const CellGrid& cells, const std::vector<char>& edges);

}  // namespace annulus
