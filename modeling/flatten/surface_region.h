#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/flatten/curved_sheet.h"
#include "modeling/flatten/plane_mesh.h"

namespace annulus {

/// Lines that bound a region of a segment, and lines within it: the points are places (theta in rad, z in mm), the
/// lines straight in the (theta, z) plane. theta is not wrapped: a region that reaches around the body and meets
/// itself is a strip 2π wide. The rim runs counter-clockwise: with the region at its left, seen from outside.
using RegionLines = PlaneMesh::Lines;

/// A region of a segment in triangles. The given points are its first vertices, in their order.
struct RegionSheet {
  CurvedSheet sheet;                     ///< Sides as long as geodesics (GeodesicSide).
  std::vector<Eigen::Vector2d> theta_z;  ///< Per vertex, rad and mm.
};

/// Fills a region with triangles whose sides are at most `element_mm` long (the chord), but for the lines' own. Fails
/// if lines cross or leave the segment's height, a part of the region was not seen (Knowledge::kUnknown), or over
/// 200,000 triangles would be needed.
[[nodiscard]] Result<RegionSheet> FillRegion(const SurfaceSegment& segment, const RegionLines& lines,
                                             double element_mm);

/// Twice the area that a closed chain of points goes around, positive if counter-clockwise.
[[nodiscard]] double TurnedArea(const std::vector<Eigen::Vector2d>& chain);

}  // namespace annulus
