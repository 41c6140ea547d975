#pragma once

#include <Eigen/Core>
#include <array>

#include "base/result.h"
#include "modeling/measure/paper_lattice.h"
#include "modeling/measure/region.h"

namespace annulus {

/// A region as the paper's discretisation sees it.
struct PaperRegion {
  double area = 0.0;    ///< mm²
  double volume = 0.0;  ///< mm³; what lies outside the planes counts negative (fig. 3.8).
  LatticePath over_c;   ///< The polygons of crossings from A to B, over C …
  LatticePath over_d;   ///< … and over D; theta of both begins alike.
};

/// Area of a triangle, mm² (paper 001, eq. 3.5).
[[nodiscard]] double TriangleArea(const std::array<Eigen::Vector3d, 3>& corners);

/// The unit direction in which plane 1 is reached along plane 2 (eq. 3.7). `normal_1` points towards the region; the
/// planes must not be parallel.
[[nodiscard]] Eigen::Vector3d ProjectionDirection(const Eigen::Vector3d& normal_1, const Eigen::Vector3d& normal_2);

/// Volume of the oblique prism between a triangle and its image along `direction` on `plane` (eqs. 3.6, 3.8, 3.9), mm³:
/// positive where the triangle's outward side faces away from the plane.
[[nodiscard]] double PrismVolume(const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& direction,
                                 const CuttingPlane& plane);

/// Area and volume of the region that the planes ABC and ABD cut, by the method of paper 001, §3.1 and 3.2, on a
/// lattice of sample points: tracing of both cuts from mesh to mesh, polygons of three to five corners where a plane
/// cuts a mesh, two triangles for each mesh inside, oblique prisms along plane 2 onto plane 1. Differs from
/// RegionBetween by the square of the mesh's size. Fails like LatticeCut; if A, B, C and D lie in one plane; or if the
/// cuts enclose no region. Does not look at what was seen.
[[nodiscard]] Result<PaperRegion> RegionOnLattice(const MeasuredSurface& body, const RegionClicks& clicks,
                                                  LatticeSize size);

}  // namespace annulus
