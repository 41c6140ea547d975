#pragma once

#include <vector>

#include "base/result.h"
#include "modeling/measure/cut_path.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

/// The four clicks of a region (paper 001, fig. 3.1).
struct RegionClicks {
  SurfacePlace a;  ///< Common to both planes.
  SurfacePlace b;  ///< Common to both planes.
  SurfacePlace c;  ///< Of plane 1.
  SurfacePlace d;  ///< Of plane 2.
};

/// The two ways from A to B that enclose a region: over C in plane 1 and over D in plane 2, without another common
/// point. theta of both begins and ends alike.
struct RegionBoundary {
  CutPath over_c;
  CutPath over_d;
};

/// Cuts the surface by the planes ABC and ABD. Fails like CutThrough; if A, B, C and D lie in one plane, if the two
/// ways go around the body instead of enclosing a region, or if they cross between A and B.
[[nodiscard]] Result<RegionBoundary> CutRegion(const MeasuredSurface& body, const RegionClicks& clicks);

/// A region of the surface cut by two planes, to first order in the surface: the movement of the skin, of the cuts over
/// it, and of the planes with their four clicks all count.
struct RegionEstimates {
  Estimate area;  ///< mm², of the skin.
  /// mm³, between the skin and the two planes. Where the skin lies inside the planes (a hollow), it counts negative
  /// (paper 001, fig. 3.8).
  Estimate volume;
  PathKnowledge knowledge;        ///< By skin area; nothing is unknown where the function succeeds.
  std::vector<PathPoint> over_c;  ///< The boundary from A over C to B …
  std::vector<PathPoint> over_d;  ///< … and from A over D to B.
};

/// Area and volume of the region that the planes ABC and ABD cut from the body (paper 001, §3.1, 3.2), on the spline
/// itself: 4 × 4 Gauss points on every knot cell and Green's theorem in cells that the cuts cross, to 1e-6 relative or
/// better; the volume as the flux of (P - A)/3 through the skin, which has divergence 1 and no flux through planes that
/// contain A. Fails like CutRegion, and if part of the region was not seen.
[[nodiscard]] Result<RegionEstimates> RegionBetween(const MeasuredSurface& body, const RegionClicks& clicks);

}  // namespace annulus
