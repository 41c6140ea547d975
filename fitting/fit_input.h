#pragma once

#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/cell_grid.h"

namespace annulus {

/// A scan without noise is fitted as if it had this much, mm.
inline constexpr double kSmallestNoise = 1e-3;

/// What the solvers are given: one star-shaped surface's samples after screening. Borrows the samples.
struct FitInput {
  std::span<const SurfaceSample> samples;
  std::vector<char> use;  ///< One flag per sample: it passed the screening.
  CellGrid cells;         ///< Of the used samples.
  double noise = 0.0;     ///< Estimated sd of one return, mm, > 0.
};

}  // namespace annulus
