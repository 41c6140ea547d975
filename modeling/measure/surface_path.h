#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A point of a path that follows the surface, or of a tape that touches it there.
struct PathPoint {
  SurfacePlace place;                                   ///< Where it lies on the surface.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   ///< Station frame, mm.
  Eigen::Vector3d by_radius = Eigen::Vector3d::Zero();  ///< d(position)/d(radius at place).
};

/// Whether a path returns to its first point.
enum class PathEnds { kOpen, kClosed };

/// A point of `surface()` that moves with its radius along the ray from the axis.
[[nodiscard]] PathPoint RadialPoint(const SplineSurface& surface, const SurfacePlace& place);

/// The length of the polygon through the points, mm, and how it follows the surface. Coincident points are allowed.
[[nodiscard]] Estimate PolygonLength(const SplineSurface& surface, const std::vector<PathPoint>& points, PathEnds ends);

/// How much of a path was seen: shares of its length.
struct PathKnowledge {
  double measured = 0.0;  ///< 0 … 1
  double unknown = 0.0;   ///< 0 … 1
};
/// Each edge of the polygon counts half for the cell of either end.
[[nodiscard]] PathKnowledge KnowledgeAlong(const MeasuredSurface& body, const std::vector<PathPoint>& points,
                                           PathEnds ends);

/// The same for the whole section at height z, by angle.
[[nodiscard]] PathKnowledge KnowledgeOfLevel(const MeasuredSurface& body, double z);

/// A length along the surface, or over it, from one place to another or around.
struct SurfaceDistance {
  Estimate length;                ///< mm
  PathKnowledge knowledge;        ///< Of the path; nothing is unknown where a function succeeds.
  std::vector<PathPoint> path{};  ///< In order; a closed path does not repeat its first point.
};

/// Fails if part of a path was not seen, naming the share.
Status CheckKnown(const PathKnowledge& knowledge, const std::string& attempted);
/// Fails if z (mm) is outside the surface, naming its range.
Status CheckInRange(const MeasuredSurface& body, double z, const std::string& attempted);

}  // namespace annulus
