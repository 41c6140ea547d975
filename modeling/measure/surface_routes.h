#pragma once

#include <Eigen/Core>
#include <vector>

#include "modeling/measure/surface_path.h"

namespace annulus {

/// Over what a route is sought.
enum class RouteSkin {
  kSurface,    ///< The surface itself.
  kRowsHulls,  ///< The convex hulls of the horizontal sections: hollows are spanned.
};

/// Rough ways from one place to another, each a polygon of points in the station frame (mm) that starts and ends at
/// the two places on the surface: the shortest one on a grid of some thousand nodes, and the others that a shorter path
/// may turn out to lie near: around the other side of the body or of a bump. At most `kMostRoutes`, the shortest first,
/// all at most a tenth longer than it. The straight line in (theta, z) is among them where the places are near each
/// other. Dijkstra's algorithm from both places; where both fronts meet, every local minimum of the sum is a route.
/// Requires different places within the surface's range.
[[nodiscard]] std::vector<std::vector<Eigen::Vector3d>> ShortRoutes(const SplineSurface& surface,
                                                                    const SurfacePlace& from, const SurfacePlace& to,
                                                                    RouteSkin skin);

/// See ShortRoutes.
inline constexpr std::size_t kMostRoutes = 4;

}  // namespace annulus
