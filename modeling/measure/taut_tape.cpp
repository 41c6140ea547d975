#include "modeling/measure/taut_tape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/string_length.h"
#include "modeling/measure/string_start.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

constexpr double kEdge = 4.0;  ///< mm, before it is refined where the tape bends.
constexpr EdgeDepths kDepths{0.05, 0.6 * kTapeDepth};
constexpr std::size_t kQuarters = 4;

/// The shorter one of the tape that starts over the hulls of the rows and the geodesic let go outward.
TautString ShortestTape(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to) {
  StringRules rules{StringSide::kOutside, PathEnds::kOpen, surface.z_min(), surface.z_max()};
  TautString over = ShortestString(surface, rules, ShortRoutes(surface, from, to, RouteSkin::kRowsHulls));
  rules.side = StringSide::kOnSurface;
  TautString along =
      LetGo(surface, ShortestString(surface, rules, ShortRoutes(surface, from, to, RouteSkin::kSurface)));
  return along.Length() < over.Length() ? std::move(along) : std::move(over);
}

/// The hull of the horizontal section as a closed string that is held in four directions, starting at theta = 0.
TautString HullString(const SplineSurface& surface, const StringRules& rules, double z) {
  constexpr std::size_t kDirections = 360;
  std::vector<Eigen::Vector2d> section;
  for (std::size_t k = 0; k < kDirections; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(kDirections);
    section.emplace_back(surface.Point(theta, z).head<2>());
  }
  const std::vector<Eigen::Vector2d> corners = ConvexHull(section);
  // Where the hull crosses each direction: the axis is inside the body, so once.
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  const auto outward = [](double theta) { return Eigen::Vector2d(std::cos(theta), std::sin(theta)); };
  const auto on_hull = [&](double theta) {
    const Eigen::Vector2d direction = outward(theta);
    double reach = surface.Radius(theta, z);
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Eigen::Vector2d& a = corners[c];
      const Eigen::Vector2d edge = corners[(c + 1) % corners.size()] - a;
      const double against = cross(direction, edge);
      if (cross(a, direction) < 0.0 || cross(direction, a + edge) < 0.0 || against <= 0.0) continue;
      reach = std::max(reach, cross(a, edge) / against);
    }
    return PointFromCylindrical(theta, reach, z);
  };
  std::vector<StringVertex> vertices;
  constexpr std::size_t kPerQuarter = 24;
  for (std::size_t k = 0; k < kQuarters * kPerQuarter; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(kQuarters * kPerQuarter);
    const Eigen::Vector3d point = on_hull(theta);
    StringVertex vertex{{theta, z}, point, VertexHold::kSliding, point.head<2>().norm() <= surface.Radius(theta, z)};
    if (k % kPerQuarter == 0) vertex.hold = VertexHold::kHeld;
    vertices.push_back(vertex);
  }
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    vertices[k].share = (vertices[(k + 1) % vertices.size()].position - vertices[k].position).norm();
  }
  return {surface, rules, std::move(vertices)};
}

}  // namespace

Result<SurfaceDistance> TautTape(const MeasuredSurface& body, const SurfacePlace& from, const SurfacePlace& to) {
  const std::string attempted = DistanceText("tape", from, to);
  const SplineSurface& surface = body.surface();
  RETURN_IF_ERROR(CheckPlaces(body, from, to, attempted));
  if (AreCoincident(surface, from, to)) return CoincidentDistance(body, from, to, attempted);

  const bool backwards = ComesBefore(to, from);
  const SurfacePlace& first = backwards ? to : from;
  const SurfacePlace& last = backwards ? from : to;
  const TautString string = Finished(surface, kEdge, kDepths, ShortestTape(surface, first, last));
  SurfaceDistance distance = MeasureString(body, string);
  RETURN_IF_ERROR(CheckKnown(distance.knowledge, attempted));
  if (backwards) std::reverse(distance.path.begin(), distance.path.end());
  return distance;
}

Result<SurfaceDistance> TautLoop(const MeasuredSurface& body, double z) {
  const std::string attempted = "measure the tape around the body at z = " + NumberText(z) + " mm";
  const SplineSurface& surface = body.surface();
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  const StringRules rules{StringSide::kOutside, PathEnds::kClosed, std::max(surface.z_min(), z - kLoopBand),
                          std::min(surface.z_max(), z + kLoopBand)};
  for (std::size_t quarter = 0; quarter < kQuarters; ++quarter) {
    const double theta = kTwoPi * static_cast<double>(quarter) / static_cast<double>(kQuarters);
    if (!(surface.Radius(theta, z) > 0.0)) {
      return Fail(attempted, "the surface reaches the ring's axis there", "choose another height");
    }
  }
  TautString start = HullString(surface, rules, z);
  start.Tighten(kFineEffort);
  start.ShareByLength();
  const TautString string = Finished(surface, kEdge, kDepths, std::move(start));
  SurfaceDistance distance = MeasureString(body, string);
  RETURN_IF_ERROR(CheckKnown(distance.knowledge, attempted));
  return distance;
}

}  // namespace annulus
