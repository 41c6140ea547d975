#pragma once

#include <string>

#include "modeling/measure/surface_routes.h"
#include "modeling/measure/taut_string.h"

namespace annulus {

/// "measure the METHOD from theta = 10 deg, z = 50 mm to theta = …", for messages.
[[nodiscard]] std::string DistanceText(const std::string& method, const SurfacePlace& from, const SurfacePlace& to);

/// Fails if a number is not finite or z is outside the surface.
Status CheckPlaces(const MeasuredSurface& body, const SurfacePlace& from, const SurfacePlace& to,
                   const std::string& attempted);

/// Whether two places are one: not further apart than numbers can tell.
[[nodiscard]] bool AreCoincident(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to);
/// The distance between coincident places. Fails if they were not seen.
[[nodiscard]] Result<SurfaceDistance> CoincidentDistance(const MeasuredSurface& body, const SurfacePlace& from,
                                                         const SurfacePlace& to, const std::string& attempted);

/// Whether `a` comes before `b` in the order in which the ends of a path are taken.
[[nodiscard]] bool ComesBefore(const SurfacePlace& a, const SurfacePlace& b);

/// An open string with equal shares along a route (ShortRoutes) between two places: on the surface under it or pushed
/// out of the body, as the rules say. Its ends are fixed. `edges` >= 2.
[[nodiscard]] TautString StringAlong(const SplineSurface& surface, const StringRules& rules,
                                     const std::vector<Eigen::Vector3d>& route, std::size_t edges);

/// The shortest string from `from` to `to` among those that the routes over `skin` lead to, taut with edges of about
/// `edge` mm but at most 1024 (32 at least).
[[nodiscard]] TautString ShortestString(const SplineSurface& surface, const StringRules& rules,
                                        const std::vector<std::vector<Eigen::Vector3d>>& routes, double edge);

}  // namespace annulus
