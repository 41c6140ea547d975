#include "modeling/measure/geodesic.h"

#include <algorithm>
#include <utility>

#include "modeling/measure/string_length.h"
#include "modeling/measure/string_start.h"

namespace annulus {
namespace {

constexpr double kEdge = 2.5;  ///< mm, before it is refined where the path bends.
constexpr EdgeDepths kDepths{0.05, 0.05};

}  // namespace

Result<SurfaceDistance> GeodesicDistance(const MeasuredSurface& body, const SurfacePlace& from,
                                         const SurfacePlace& to) {
  const std::string attempted = DistanceText("geodesic", from, to);
  const SplineSurface& surface = body.surface();
  RETURN_IF_ERROR(CheckPlaces(body, from, to, attempted));
  if (AreCoincident(surface, from, to)) return CoincidentDistance(body, from, to, attempted);

  const bool backwards = ComesBefore(to, from);
  const SurfacePlace& first = backwards ? to : from;
  const SurfacePlace& last = backwards ? from : to;
  const StringRules rules{StringSide::kOnSurface, PathEnds::kOpen, surface.z_min(), surface.z_max()};
  TautString coarse = ShortestString(surface, rules, ShortRoutes(surface, first, last, RouteSkin::kSurface));
  const TautString string = Finished(surface, kEdge, kDepths, std::move(coarse));
  SurfaceDistance distance = MeasureString(body, string);
  RETURN_IF_ERROR(CheckKnown(distance.knowledge, attempted));
  if (backwards) std::reverse(distance.path.begin(), distance.path.end());
  return distance;
}

double RimShare(const SplineSurface& surface, const std::vector<PathPoint>& path) {
  double length = 0.0;
  double along = 0.0;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const double z = path[k].place.z;
    const double edge = (path[k + 1].position - path[k].position).norm();
    length += edge;
    if (z == path[k + 1].place.z && (z == surface.z_min() || z == surface.z_max())) along += edge;
  }
  return length > 0.0 ? along / length : 0.0;
}

}  // namespace annulus
