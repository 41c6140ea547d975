#include "modeling/landmarks/body_landmarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/frames.h"
#include "modeling/landmarks/landmark_catalog.h"
#include "modeling/landmarks/level_vertex.h"
#include "modeling/landmarks/mid_direction.h"
#include "modeling/landmarks/surface_vertex.h"

namespace annulus {
namespace {

/// sd of placing across and up, mm: see docs/landmarks.md.
struct Placing {
  double across = 0.0;
  double up = 0.0;
};
constexpr Placing kNeckSide{3.0, 2.0};
constexpr Placing kNeckFront{3.0, 7.0};
constexpr Placing kNeckBack{3.0, 10.0};
constexpr Placing kNeckByProportion{3.0, 15.0};
constexpr Placing kShoulder{6.0, 6.0};
constexpr Placing kBust{2.0, 2.0};
constexpr Placing kBustByProportion{20.0, 10.0};

constexpr double kNeckHalf = 6.0;       // mm: half the height over which the outline's slope is taken
constexpr double kShoulderHalf = 12.0;  // mm; shoulders bend less sharply
constexpr double kChord = 25.0;         // mm above and below a bend of the mid profile
constexpr double kSector = RadiansFromDegrees(60.0);

constexpr std::string_view kHidden = "the ring did not see the place";

Landmarks Omitted(std::string_view id, std::string_view why) { return {{}, {OmittedText(id, why)}}; }

/// A point of the surface; omitted if the place was not seen.
Landmarks PointAt(const MeasuredSurface& body, std::string_view id, std::pair<Estimate, Estimate> theta_and_z,
                  double confidence, const Placing& placing) {
  Landmark point = FromCatalog(id);
  point.theta = std::move(theta_and_z.first);
  point.z = std::move(theta_and_z.second);
  point.theta.value = WrapAngle(point.theta.value);
  if (body.KnowledgeAt(point.theta.value, point.z.value) == Knowledge::kUnknown) return Omitted(id, kHidden);
  point.position = body.Point(point.theta.value, point.z.value);
  point.confidence = std::clamp(confidence, 0.0, 1.0);
  point.placing_across = placing.across;
  point.placing_up = placing.up;
  return {{std::move(point)}, {}};
}

Landmarks AsProportion(Landmarks points) {
  for (Landmark& point : points.found) point.source = LandmarkSource::kProportion;
  return points;
}

Eigen::Vector3d Horizontal(double direction) { return {std::cos(direction), std::sin(direction), 0.0}; }

/// The direction, rad, in which the section at height z reaches farthest towards `side`, following z.
Estimate FarthestAt(const MeasuredSurface& body, double side, const Estimate& z) {
  const SplineSurface& surface = body.surface();
  double best = side;
  for (double theta = side - kSector; theta <= side + kSector; theta += RadiansFromDegrees(1.0)) {
    if (surface.Radius(theta, z.value) * std::cos(theta - side) >
        surface.Radius(best, z.value) * std::cos(best - side)) {
      best = theta;
    }
  }
  VertexQuery query{SurfaceField::Along(Horizontal(side))};
  query.freedom = VertexFreedom::kAcross;
  const auto vertex = FindVertexAlong(surface, Estimate{best, {}}, z, query);
  return vertex ? vertex->theta : Estimate{best, {}};
}

/// How sharply an outline turns at z: its change of slope over 30 mm, as a share.
double Sharpness(const HeightFunction& slope, double z) {
  const double turn = std::abs(slope.value(z + 15.0) - slope.value(z - 15.0));
  return turn / (turn + 1.0);
}

constexpr double kFortyFive = -1.0;  // slope of an outline that falls outwards

/// Below `neck`, the height at which an outline first slopes by 45 degrees.
std::optional<Estimate> NeckSide(const SplineSurface& surface, const HeightFunction& slope, double neck) {
  const double lowest = std::max(neck - 180.0, surface.z_min() + 2.0 * kNeckHalf);
  if (neck + kNeckHalf > surface.z_max() || neck <= lowest) return std::nullopt;
  return FindCrossing(surface, slope, {neck, lowest, kFortyFive, Crossing::kRising});
}

/// Below the side neck point, the height at which the outline turns down again.
std::optional<Estimate> Shoulder(const SplineSurface& surface, const HeightFunction& reach, double neck_side) {
  constexpr double kNearest = 40.0;  // mm outside the neck
  constexpr double kFarthest = 260.0;
  const double lowest = std::max(neck_side - 200.0, surface.z_min() + 2.0 * kShoulderHalf);
  if (neck_side <= lowest || neck_side + kShoulderHalf > surface.z_max()) return std::nullopt;
  const HeightFunction slope = SlopeOf(reach, kShoulderHalf);
  std::optional<Estimate> found = FindCrossing(surface, slope, {neck_side, lowest, kFortyFive, Crossing::kFalling});
  if (!found) return std::nullopt;
  const double out = reach.value(found->value) - reach.value(neck_side);
  return out >= kNearest && out <= kFarthest ? found : std::nullopt;
}

/// Side neck point and shoulder point of one side.
Landmarks SidePoints(const MeasuredSurface& body, double side, const Landmark& neck, std::string_view neck_id,
                     std::string_view shoulder_id) {
  const SplineSurface& surface = body.surface();
  const HeightFunction reach = ReachOver(SectionSampler(surface, EvenDirections(360)), side, kSector);
  const HeightFunction slope = SlopeOf(reach, kNeckHalf);
  const std::optional<Estimate> base = NeckSide(surface, slope, neck.z.value);
  if (!base) {
    return {{}, {OmittedText(neck_id, "the outline does not widen to a shoulder"), OmittedText(shoulder_id, kHidden)}};
  }
  Landmarks points =
      PointAt(body, neck_id, {FarthestAt(body, side, *base), *base}, Sharpness(slope, base->value), kNeckSide);
  const std::optional<Estimate> tip = Shoulder(surface, reach, base->value);
  const Landmarks shoulder = tip ? PointAt(body, shoulder_id, {FarthestAt(body, side, *tip), *tip},
                                           0.8 * Sharpness(slope, tip->value), kShoulder)
                                 : Omitted(shoulder_id, "the outline shows no end of a shoulder");
  points.found.insert(points.found.end(), shoulder.found.begin(), shoulder.found.end());
  points.omitted.insert(points.omitted.end(), shoulder.omitted.begin(), shoulder.omitted.end());
  return points;
}

/// The pit of the neck: the point of the mid profile in front that is set back most.
Landmarks NeckFront(const MeasuredSurface& body, const BodyShape& shape, double neck) {
  constexpr std::string_view kId = "neck_front";
  const SplineSurface& surface = body.surface();
  VertexQuery query{SurfaceField::Along(Horizontal(shape.front))};
  query.shape = VertexShape::kHollow;
  query.freedom = VertexFreedom::kUp;
  query.half_up = 10.0;
  SurfacePlace best;
  double least = std::numeric_limits<double>::infinity();
  for (double z = std::max(neck - 120.0, surface.z_min()); z <= neck + 5.0; z += 2.5) {
    const SurfacePlace place{MidDirection(body, shape.front, z), z};
    const double reach = query.field.At(surface, place);
    if (reach >= least) continue;
    least = reach;
    best = place;
  }
  const Estimate theta{best.theta, {}};
  const auto vertex = FindVertexAlong(surface, theta, Estimate{best.z, {}}, query);
  if (!vertex) return Omitted(kId, "the profile is not set back between chin and chest");
  return PointAt(body, kId, {theta, vertex->z}, vertex->confidence, kNeckFront);
}

/// The bulge of the back's profile near the height `base` of the neck's base.
std::optional<std::pair<Estimate, SurfaceVertex>> FindBulge(const MeasuredSurface& body, double behind, double base) {
  constexpr double kReach = 50.0;   // mm
  constexpr double kWeakest = 2.0;  // mm over the chord; a round back has less
  const SplineSurface& surface = body.surface();
  VertexQuery query{SurfaceField::Along(Horizontal(behind)).OverChord(0.0, kChord)};
  query.freedom = VertexFreedom::kUp;
  query.half_up = 10.0;
  const double margin = kChord + query.half_up;
  SurfacePlace best;
  double strongest = kWeakest;
  for (double z = std::max(base - kReach, surface.z_min() + margin);
       z <= std::min(base + kReach, surface.z_max() - margin); z += 2.5) {
    const SurfacePlace place{MidDirection(body, behind, z), z};
    const double height = query.field.At(surface, place);
    if (height <= strongest) continue;
    strongest = height;
    best = place;
  }
  if (strongest <= kWeakest) return std::nullopt;
  const Estimate theta{best.theta, {}};
  auto vertex = FindVertexAlong(surface, theta, Estimate{best.z, {}}, query);
  if (!vertex || std::abs(vertex->z.value - base) > kReach) return std::nullopt;
  return std::pair(theta, std::move(*vertex));
}

/// `front`: the front neck point, null if it was not found; the cervicale does not lie below it.
Landmarks NeckBack(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& sides, const Landmark* front) {
  constexpr std::string_view kId = "neck_back";
  const Landmark* right = sides.Find("neck_right");
  const Landmark* left = sides.Find("neck_left");
  if (right == nullptr || left == nullptr) return Omitted(kId, "the side neck points are missing");
  const double behind = shape.front + kPi;
  const Estimate base = Combine(0.5, right->z, 0.5, left->z);
  const auto bulge = FindBulge(body, behind, base.value);
  if (bulge && (front == nullptr || bulge->second.z.value >= front->z.value)) {
    const double height = bulge->second.height;
    return PointAt(body, kId, {bulge->first, bulge->second.z}, height / (height + 2.0), kNeckBack);
  }
  const Estimate theta{MidDirection(body, behind, base.value), {}};
  return AsProportion(PointAt(body, kId, {theta, base}, 0.2, kNeckByProportion));
}

/// The most forward point of one half of the chest; `turn` is -1 for the right half, +1 for the left one.
Landmarks BustPoint(const MeasuredSurface& body, const BodyShape& shape, const Estimate& chest, double turn,
                    std::string_view id) {
  const SplineSurface& surface = body.surface();
  const Eigen::Vector3d forward = Horizontal(shape.front);
  constexpr double kNearest = RadiansFromDegrees(8.0);
  constexpr double kWidest = RadiansFromDegrees(50.0);
  SurfacePlace best;
  double farthest = -std::numeric_limits<double>::infinity();
  for (double z = chest.value - 40.0; z <= chest.value + 20.0; z += 5.0) {
    if (z < surface.z_min() || z > surface.z_max()) continue;
    for (double aside = kNearest; aside <= kWidest; aside += RadiansFromDegrees(2.0)) {
      const SurfacePlace place{shape.front + turn * aside, z};
      const double reach = surface.Point(place.theta, z).dot(forward);
      if (reach <= farthest) continue;
      farthest = reach;
      best = place;
    }
  }
  VertexQuery query{SurfaceField::Along(forward)};
  query.half_across = 15.0;
  query.half_up = 15.0;
  const auto vertex = FindVertex(surface, best, query);
  const bool on_its_half = vertex && turn * (vertex->theta.value - shape.front) > 0.5 * kNearest;
  if (on_its_half && std::abs(vertex->z.value - chest.value) <= 60.0) {
    return PointAt(body, id, {vertex->theta, vertex->z}, vertex->confidence, kBust);
  }
  // A flat chest: halfway between the mid-plane and the side, at the chest level.
  const double theta = shape.front + turn * RadiansFromDegrees(40.0);
  return AsProportion(PointAt(body, id, {Estimate{theta, {}}, chest}, 0.1, kBustByProportion));
}

}  // namespace

Landmarks FindBodyPoints(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& levels) {
  Landmarks points;
  const auto add = [&points](const Landmarks& more) {
    points.found.insert(points.found.end(), more.found.begin(), more.found.end());
    points.omitted.insert(points.omitted.end(), more.omitted.begin(), more.omitted.end());
  };
  if (const Landmark* neck = levels.Find("level.neck")) {
    Landmarks sides = SidePoints(body, shape.front - kPi / 2.0, *neck, "neck_right", "shoulder_right");
    const Landmarks left = SidePoints(body, shape.front + kPi / 2.0, *neck, "neck_left", "shoulder_left");
    sides.found.insert(sides.found.end(), left.found.begin(), left.found.end());
    sides.omitted.insert(sides.omitted.end(), left.omitted.begin(), left.omitted.end());
    const Landmarks front = NeckFront(body, shape, neck->z.value);
    add(front);
    add(NeckBack(body, shape, sides, front.Find("neck_front")));
    add(sides);
  } else {
    for (const char* id : {"neck_front", "neck_back", "neck_right", "neck_left", "shoulder_right", "shoulder_left"}) {
      add(Omitted(id, "the neck level is missing"));
    }
  }
  if (const Landmark* chest = levels.Find("level.chest")) {
    add(BustPoint(body, shape, chest->z, -1.0, "bust_right"));
    add(BustPoint(body, shape, chest->z, 1.0, "bust_left"));
  } else {
    for (const char* id : {"bust_right", "bust_left"}) add(Omitted(id, "the chest level is missing"));
  }
  return points;
}

}  // namespace annulus
