#pragma once

#include <cstddef>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// A body of clay made of a measured surface, and how well.
struct ClayOfSurface {
  ClayBody body;
  /// Largest distance found between body and surface, at 5 × 5 places of every leaf, mm.
  double largest_error_mm = 0.0;
  /// Of the body's volume, less the surface's, over the surface's.
  double volume_error = 0.0;
  /// Base patches: `columns` around from theta = 0, `rows` upwards from z_min, numbered row by row; then the lower
  /// cap's and the upper cap's, `columns` each.
  std::size_t columns = 0;
  std::size_t rows = 0;
};

/// The skin of a segment, closed by flat caps at its ends, as bicubic patches: on a grid of the segment's coarsest
/// knots, each patch has the surface's own position, slopes and twist at its corners, and is cut in four until it is
/// within `tolerance` mm (r·cos theta is no polynomial) and all of them together within 1e-7 of its volume. u runs
/// along theta, v along z. Fails if that takes more than `most_leaves` or the radius is not positive somewhere.
Result<ClayOfSurface> ClayFromSurface(const SurfaceSegment& segment, double tolerance = 1e-4,
                                      std::size_t most_leaves = 200'000);

}  // namespace annulus
