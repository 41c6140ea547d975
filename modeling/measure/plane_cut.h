#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "modeling/measure/cutting_plane.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

/// On what a plane cut is taken.
enum class CutMethod {
  kSpline,  ///< On the spline surface itself: to 1e-6 of the length or better.
  kPaper,  ///< On the mesh of the scan's own lattice of angles and levels (paper 001, eqs. 3.2–3.4), see PaperLattice.
};

/// Distance from one place to another over the surface along the plane through both and `via` (paper 001, §3.3 (1)):
/// the way that passes `via`. The gradient counts the surface's movement along the way and the plane's, which follows
/// the three places. On the spline, what is unresolved (UnresolvedLength) is added. Fails for places that coincide, lie
/// on one line or outside the scanned range; if the cut leaves the range, closes without passing all three places, or
/// crosses what was not seen.
[[nodiscard]] Result<SurfaceDistance> DistanceByPlane(const MeasuredSurface& body, const SurfacePlace& from,
                                                      const SurfacePlace& via, const SurfacePlace& to,
                                                      CutMethod method);

/// The same along the plane through two places that contains the direction of sight `view` (paper 001, §3.3 (2), eq.
/// 3.10), which points from the viewer towards the body, any length: the way that lies nearer to the viewer; if only
/// one of the two ways stays on the scanned surface, that one. Fails alike, and if one place lies behind the other.
[[nodiscard]] Result<SurfaceDistance> DistanceByView(const MeasuredSurface& body, const SurfacePlace& from,
                                                     const SurfacePlace& to, const Eigen::Vector3d& view,
                                                     CutMethod method);

/// The loop in which a plane of any tilt cuts the body, to first order in the surface; the plane is at rest. Lengths
/// hold what is unresolved, as those of SectionAt do.
struct TiltedGirth {
  Estimate perimeter;                ///< mm; length of the loop.
  Estimate tape;                     ///< mm; length of its convex hull in the plane: what a tape reads.
  Estimate area;                     ///< mm², enclosed by the loop.
  PathKnowledge knowledge;           ///< Of the loop; nothing is unknown where the function succeeds.
  std::vector<PathPoint> loop;       ///< Counter-clockwise seen from the normal's side that points up.
  std::vector<PathPoint> tape_path;  ///< Corners of the hull, in the same order.
};

/// Measures the loop around the axis in which `plane` (unit normal) cuts the surface; loops beside the axis are left
/// out. Fails unless the plane makes exactly one closed loop around the axis within the scanned range, all of it seen.
[[nodiscard]] Result<TiltedGirth> GirthInPlane(const MeasuredSurface& body, const CuttingPlane& plane);

}  // namespace annulus
