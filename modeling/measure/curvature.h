#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// How the surface bends at a place. Curvatures are positive where it bends away from the outside, as a sphere of
/// radius R does (1/R).
struct SurfaceCurvature {
  SurfacePlace place;
  double largest = 0.0;   ///< Principal curvature, 1/mm; >= smallest.
  double smallest = 0.0;  ///< Principal curvature, 1/mm.
  /// Unit tangents in which it bends so, at right angles, upward (level ones towards rising theta); station frame. Any
  /// such pair where both curvatures are equal.
  Eigen::Vector3d largest_direction = Eigen::Vector3d::Zero();
  Eigen::Vector3d smallest_direction = Eigen::Vector3d::Zero();
  Estimate mean;      ///< (largest + smallest) / 2, 1/mm
  Estimate gaussian;  ///< largest · smallest, 1/mm²
};

/// Curvature at a place by the two fundamental forms of surface(). A C2 surface: continuous over all knots. Fails where
/// the place is not finite, outside the scanned range or not seen, or where the surface meets the ring's axis.
[[nodiscard]] Result<SurfaceCurvature> CurvatureAt(const MeasuredSurface& body, const SurfacePlace& place);

}  // namespace annulus
