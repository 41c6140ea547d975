#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// Where the nearest place of a surface lies.
enum class NearestPlace {
  kWithin,  ///< The line to it stands upright on the surface.
  kAtEnd,   ///< At the upper or lower end of the scanned range, where the surface is cut open.
};

/// The nearest place of the surface to a point.
struct ClosestPoint {
  SurfacePlace place;                                  ///< theta in [0, 2 pi).
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  NearestPlace kind = NearestPlace::kWithin;
  Knowledge knowledge = Knowledge::kMeasured;  ///< Of the place; never unknown.
  /// Distance from the surface, mm: negative where the point is inside, which is between the surface and the ring's
  /// axis at a height in the scanned range; positive elsewhere.
  Estimate signed_distance;
};

/// The nearest of all places of surface(), for any finite point (station frame, mm). Global: patches are left out only
/// if the box of their control coefficients is farther than what was found. Of places as near to within 1e-9 mm the
/// lowest one counts, then the one with the smallest theta. Fails if the point is not finite or farther than 1e6 mm
/// from the origin, or if the nearest place was not seen.
[[nodiscard]] Result<ClosestPoint> NearestOnSurface(const MeasuredSurface& body, const Eigen::Vector3d& p_in_station);

}  // namespace annulus
