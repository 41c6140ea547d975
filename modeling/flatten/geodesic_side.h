#pragma once

#include <Eigen/Core>

#include "fitting/surface_model.h"

namespace annulus {

/// Length of the geodesic between two near places (theta, z) of a segment, rad and mm: the shortest cubic in the
/// (theta, z) plane through both, by Newton's method; within 1e-9 of it where a side is a tenth of the radius of
/// curvature and the surface smooth. theta is not wrapped. Never less than the chord. mm
[[nodiscard]] double GeodesicSide(const SurfaceSegment& segment, const Eigen::Vector2d& from,
                                  const Eigen::Vector2d& to);

/// Length of the line that is straight in the (theta, z) plane, mm.
[[nodiscard]] double StraightLength(const SurfaceSegment& segment, const Eigen::Vector2d& from,
                                    const Eigen::Vector2d& to);

}  // namespace annulus
