#include "modeling/measure/string_start.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/string_length.h"

namespace annulus {
namespace {

constexpr double kCoarseEdge = 8.0;  ///< mm
constexpr std::size_t kFewestCoarse = 16;
constexpr std::size_t kMostCoarse = 64;
constexpr TightenEffort kCoarseEffort{15, 1e-5};
constexpr double kHopeless = 1.05;  ///< Times the shortest: where finer edges would only make it longer.
constexpr EdgeDepths kCoarseDepths{0.5, 0.5};
constexpr int kRounds = 3;
constexpr std::size_t kMostParts = 8;
constexpr std::size_t kMostEdges = 2000;
constexpr double kCoincident = 1e-9;  ///< mm

std::string PlaceText(const SurfacePlace& place) {
  return "theta = " + NumberText(DegreesFromRadians(place.theta)) + " deg, z = " + NumberText(place.z) + " mm";
}

}  // namespace

std::string DistanceText(const std::string& method, const SurfacePlace& from, const SurfacePlace& to) {
  return "measure the " + method + " from " + PlaceText(from) + " to " + PlaceText(to);
}

Status CheckPlaces(const MeasuredSurface& body, const SurfacePlace& from, const SurfacePlace& to,
                   const std::string& attempted) {
  for (const SurfacePlace& place : {from, to}) {
    if (!std::isfinite(place.theta)) return Fail(attempted, "theta is not a number", "give an angle in degrees");
    RETURN_IF_ERROR(CheckInRange(body, place.z, attempted));
    if (!(body.surface().Radius(place.theta, place.z) > 0.0)) {
      return Fail(attempted, "the surface reaches the ring's axis at " + PlaceText(place), "choose another place");
    }
    // A tape may leave the surface at once: what its path touches does not tell of its ends.
    if (body.KnowledgeAt(place.theta, place.z) == Knowledge::kUnknown) {
      return Fail(attempted, "the surface at " + PlaceText(place) + " was not seen", "choose a place that was scanned");
    }
  }
  return {};
}

bool AreCoincident(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to) {
  return (surface.Point(to.theta, to.z) - surface.Point(from.theta, from.z)).norm() <= kCoincident;
}

Result<SurfaceDistance> CoincidentDistance(const MeasuredSurface& body, const SurfacePlace& from,
                                           const SurfacePlace& to, const std::string& attempted) {
  const Knowledge known = body.KnowledgeAt(from.theta, from.z);
  const PathKnowledge share{known == Knowledge::kMeasured ? 1.0 : 0.0, known == Knowledge::kUnknown ? 1.0 : 0.0};
  RETURN_IF_ERROR(CheckKnown(share, attempted));
  return SurfaceDistance{{0.0, {}}, share, {RadialPoint(body.surface(), from), RadialPoint(body.surface(), to)}};
}

bool ComesBefore(const SurfacePlace& a, const SurfacePlace& b) {
  return std::make_tuple(WrapAngle(a.theta), a.z) < std::make_tuple(WrapAngle(b.theta), b.z);
}

TautString StringAlong(const SplineSurface& surface, const StringRules& rules,
                       const std::vector<Eigen::Vector3d>& route, std::size_t edges) {
  std::vector<double> along{0.0};
  for (std::size_t k = 0; k + 1 < route.size(); ++k) along.push_back(along.back() + (route[k + 1] - route[k]).norm());
  std::vector<StringVertex> vertices;
  std::size_t piece = 0;
  for (std::size_t k = 0; k <= edges; ++k) {
    const double at = along.back() * static_cast<double>(k) / static_cast<double>(edges);
    while (piece + 2 < route.size() && along[piece + 1] <= at) ++piece;
    const double width = along[piece + 1] - along[piece];
    const double t = width > 0.0 ? std::clamp((at - along[piece]) / width, 0.0, 1.0) : 0.0;
    const Eigen::Vector3d point = route[piece] + t * (route[piece + 1] - route[piece]);
    const bool end = k == 0 || k == edges;
    if (rules.side == StringSide::kOutside && !end) {
      vertices.push_back(VertexNear(surface, rules, point));
    } else {
      vertices.push_back(VertexAt(
          surface, {WrapAngle(std::atan2(point.y(), point.x())), std::clamp(point.z(), rules.z_min, rules.z_max)}));
    }
    if (end) vertices.back().hold = VertexHold::kFixed;
  }
  return {surface, rules, std::move(vertices)};
}

TautString Refined(const SplineSurface& surface, const EdgeDepths& depths, const TightenEffort& effort,
                   TautString string) {
  for (int round = 0; round < kRounds && string.edge_count() < kMostEdges; ++round) {
    std::vector<std::size_t> parts;
    for (std::size_t k = 0; k < string.edge_count(); ++k) {
      const double depth = DepthOfEdge(surface, string, k);
      const double limit = RunsOnSurface(surface, string, k) ? depths.on_surface : depths.straight;
      // The depth of a chord falls with the square of its length.
      parts.push_back(depth <= limit ? 1
                                     : std::min(kMostParts, 1 + static_cast<std::size_t>(std::sqrt(depth / limit))));
    }
    if (std::all_of(parts.begin(), parts.end(), [](std::size_t part) { return part == 1; })) break;
    string.Split(parts);
    string.Tighten(effort);
  }
  return string;
}

TautString ShortestString(const SplineSurface& surface, const StringRules& rules,
                          const std::vector<std::vector<Eigen::Vector3d>>& routes) {
  std::optional<TautString> best;
  for (const std::vector<Eigen::Vector3d>& route : routes) {
    double length = 0.0;
    for (std::size_t k = 0; k + 1 < route.size(); ++k) length += (route[k + 1] - route[k]).norm();
    const auto edges = static_cast<std::size_t>(std::min(length / kCoarseEdge, 1e6));
    TautString string = StringAlong(surface, rules, route, std::clamp(edges, kFewestCoarse, kMostCoarse));
    string.Tighten(kCoarseEffort);
    if (best && string.Length() > kHopeless * best->Length()) continue;
    string = Refined(surface, kCoarseDepths, kCoarseEffort, std::move(string));
    if (!best || string.Length() < best->Length()) best = std::move(string);
  }
  return std::move(*best);
}

TautString LetGo(const SplineSurface& surface, const TautString& string) {
  StringRules rules = string.rules();
  rules.side = StringSide::kOutside;
  TautString outside(surface, rules, string.vertices());
  outside.Tighten(kCoarseEffort);
  return Refined(surface, kCoarseDepths, kCoarseEffort, std::move(outside));
}

TautString Finished(const SplineSurface& surface, double edge, const EdgeDepths& depths, TautString string) {
  while (string.edge_count() < kMostEdges / 2 && string.Length() > edge * static_cast<double>(string.edge_count())) {
    string.Split(std::vector<std::size_t>(string.edge_count(), 2));
    string.Tighten(kFineEffort);
  }
  return Refined(surface, depths, kFineEffort, std::move(string));
}

}  // namespace annulus
