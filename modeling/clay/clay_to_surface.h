#pragma once

#include <cstddef>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/clay/clay_convert.h"

namespace annulus {

/// A measured surface after clay that was made of it has been shaped, and how well it follows the clay.
struct SurfaceOfClay {
  SurfaceSegment segment;
  /// Of what shaping did, along the normal of the surface as it was, mm, at 3 × 3 places of every piece between those
  /// fitted. What the clay was off before (ClayOfSurface::largest_error_mm) comes on top.
  double largest_error_mm = 0.0;
  double largest_growth_mm = 0.0;  ///< Of the radius, absolute.
  double volume_mm3 = 0.0;
  /// Of the surface's volume, less the clay's, over the clay's.
  double volume_error = 0.0;
  /// How far the clay's caps are from level planes, mm: what is beyond the segment's ends is left out.
  double caps_off_mm = 0.0;
  bool covariance_kept = true;   ///< False: with so many knots it would have been too large, and was left out.
  std::size_t pieces_split = 0;  ///< Of the segment's pieces, and pieces of these, for more knots.
};

/// How closely.
struct SurfaceOfClayOptions {
  /// Knots are put half-way between the segment's own where it is off by more, mm; infinite: nowhere.
  double tolerance_mm = 0.1;
  std::size_t most_coefficients = std::size_t{1} << 21U;  ///< Of the tensor form on the finest level.
};

/// The way back from ClayFromSurface or ClayFromPaper: the radius grows by what it grew on the clay, found by level
/// rays from the axis that meet the patches (Newton), before and after. Least squares on the segment's own knots, and
/// finer ones where those do not follow; clay that was not touched gives the segment back to the bit. Ends that moved
/// take the knots along. What was measured and the covariance stay those of the measured surface; a surface P(u, v)
/// becomes its tensor form. `made`: of that segment; `shaped`: it after operations. Fails, with where, on an undercut:
/// it has no radius.
Result<SurfaceOfClay> SurfaceFromClay(const SurfaceSegment& segment, const ClayOfSurface& made, const ClayBody& shaped,
                                      const SurfaceOfClayOptions& options = {});

}  // namespace annulus
