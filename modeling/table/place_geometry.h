#pragma once

#include <Eigen/Core>

#include "modeling/table/measurement_list.h"

namespace annulus {

/// A place of the surface, and how its position follows what determines it.
struct PlaceFrame {
  Eigen::Vector3d position;   ///< Station frame, mm.
  Eigen::Vector3d by_radius;  ///< d(position)/d(radius at the place).
  Eigen::Vector3d by_theta;   ///< d(position)/d(theta) along the surface, mm/rad.
  Eigen::Vector3d by_z;       ///< d(position)/dz along the surface, mm/mm.
};
[[nodiscard]] PlaceFrame FrameAt(const MeasuredSurface& body, const SurfacePlace& place);

/// The place of a landmark that is a point.
[[nodiscard]] SurfacePlace PlaceOf(const Landmark& landmark);

/// Makes a measurement follow a point landmark: `derivative` is that of the value by the point's position.
void FollowPoint(RawMeasurement& raw, const MeasuredSurface& body, const Landmark& landmark,
                 const Eigen::Vector3d& derivative);

/// The same without the radius at the landmark: for values whose own gradient knows that already, as a path's does that
/// ends at the landmark.
void FollowPlace(RawMeasurement& raw, const MeasuredSurface& body, const Landmark& landmark,
                 const Eigen::Vector3d& derivative);

/// Straight distance of two landmarks, mm.
[[nodiscard]] RawMeasurement StraightDistance(const MeasuredSurface& body, const Landmark& a, const Landmark& b);

/// Angle of the straight line from `from` to `to` under the horizontal, degrees; positive where `to` is lower.
[[nodiscard]] RawMeasurement SlopeBelowHorizontal(const MeasuredSurface& body, const Landmark& from,
                                                  const Landmark& to);

}  // namespace annulus
