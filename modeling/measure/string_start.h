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

/// How deep straight edges may cut below the surface, mm: those that only stand for a curve on it, and those that are
/// straight pieces of the path.
struct EdgeDepths {
  double on_surface = 0.0;
  double straight = 0.0;
};

/// The string with the edges divided that are deeper, and taut again, until none is (at most some rounds).
[[nodiscard]] TautString Refined(const SplineSurface& surface, const EdgeDepths& depths, const TightenEffort& effort,
                                 TautString string);

/// The effort of a final result: a string on a smooth surface is then exact to 1e-9.
inline constexpr TightenEffort kFineEffort{6, 1e-9};

/// The shortest string among those that the routes lead to, taut but coarse.
[[nodiscard]] TautString ShortestString(const SplineSurface& surface, const StringRules& rules,
                                        const std::vector<std::vector<Eigen::Vector3d>>& routes);

/// A coarse string on the surface let go outward: never longer than it was.
[[nodiscard]] TautString LetGo(const SplineSurface& surface, const TautString& string);

/// A coarse string with its edges divided until they are `edge` mm long and not too deep, taut all the while.
[[nodiscard]] TautString Finished(const SplineSurface& surface, double edge, const EdgeDepths& depths,
                                  TautString string);

}  // namespace annulus
