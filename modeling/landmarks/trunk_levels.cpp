#include "modeling/landmarks/trunk_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/frames.h"
#include "modeling/landmarks/girth_profile.h"
#include "modeling/landmarks/level_vertex.h"
#include "modeling/landmarks/mid_direction.h"
#include "modeling/landmarks/surface_vertex.h"

namespace annulus {
namespace {

constexpr double kFrontSector = RadiansFromDegrees(50.0);

/// sd of placing, mm: see docs/landmarks.md.
constexpr double kArmpitPlacing = 25.0;
constexpr double kGroove = 25.0;  // mm; half of how far the groove beside an arm hides the trunk above the armpit
constexpr double kStumpPlacing = 5.0;
constexpr double kForwardPlacing = 3.0;
constexpr double kBendPlacing = 3.0;
constexpr double kNavelPlacing = 2.0;
constexpr double kCrotchPlacing = 12.0;
constexpr double kChestByProportion = 20.0;
constexpr double kUnderBustByProportion = 15.0;
constexpr double kNavelByProportion = 20.0;
constexpr double kIliacByProportion = 15.0;

HeightFunction FrontOutline(const MeasuredSurface& body, const BodyShape& shape) {
  return ReachOver(SectionSampler(body.surface(), EvenDirections(360)), shape.front, kFrontSector);
}

/// The height between `low` and `high`, looked at every 5 mm, at which a function is largest; none at an end.
std::optional<double> InnerMaximum(const HeightFunction& function, double low, double high) {
  std::optional<double> best;
  double largest = -std::numeric_limits<double>::infinity();
  bool inner = false;
  for (double z = low; z <= high; z += kGirthStep) {
    const double value = function.value(z);
    if (value <= largest) continue;
    largest = value;
    best = z;
    inner = z > low && z + kGirthStep <= high;
  }
  return inner ? best : std::nullopt;
}

Landmark ByProportion(std::string_view id, Estimate z, double placing) {
  constexpr double kGuess = 0.2;
  Landmark level = LevelAt(id, std::move(z), kGuess, placing);
  level.source = LandmarkSource::kProportion;
  return level;
}

Landmarks Omitted(std::string_view id, std::string_view why) { return {{}, {OmittedText(id, why)}}; }

/// How deep the surface lies at a place below its surroundings `around` mm away, along `direction`, mm: the least of
/// four opposite pairs' means.
double HollowAt(const SplineSurface& surface, const SurfacePlace& place, const Eigen::Vector3d& direction,
                double around) {
  const double radius = surface.Radius(place.theta, place.z);
  const double here = surface.Point(place.theta, place.z).dot(direction);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const double across = around * std::cos(k * kPi / 4.0) / std::max(radius, around);
    const double up = around * std::sin(k * kPi / 4.0);
    const double pair = surface.Point(place.theta + across, place.z + up).dot(direction) +
                        surface.Point(place.theta - across, place.z - up).dot(direction);
    least = std::min(least, 0.5 * pair - here);
  }
  return least;
}

/// The navel: the deepest small hollow of the mid-plane in front from a little above the waist to midway to the hip.
std::optional<SurfaceVertex> FindNavel(const MeasuredSurface& body, const BodyShape& shape, double waist, double hip) {
  constexpr double kDeepEnough = 2.0;  // mm; less is a fold or noise
  constexpr double kAround = 15.0;     // mm
  const SplineSurface& surface = body.surface();
  const Eigen::Vector3d forward(std::cos(shape.front), std::sin(shape.front), 0.0);
  const double middle = MidDirection(body, shape.front, waist);
  SurfacePlace best;
  double deepest = kDeepEnough;
  for (double z = 0.4 * waist + 0.6 * hip; z <= waist + 20.0; z += 2.5) {
    if (z - kAround < surface.z_min() || z + kAround > surface.z_max()) continue;
    for (int k = -4; k <= 4; ++k) {
      const SurfacePlace place{middle + k * RadiansFromDegrees(1.5), z};
      const double depth = HollowAt(surface, place, forward, kAround);
      if (depth <= deepest || body.KnowledgeAt(place.theta, z) != Knowledge::kMeasured) continue;
      deepest = depth;
      best = place;
    }
  }
  if (deepest <= kDeepEnough) return std::nullopt;
  VertexQuery query{SurfaceField::Along(forward)};
  query.shape = VertexShape::kHollow;
  return FindVertex(surface, best, query);
}

}  // namespace

Landmark LevelAt(std::string_view id, Estimate z, double confidence, double placing) {
  Landmark level = FromCatalog(id);
  level.position.z() = z.value;
  level.z = std::move(z);
  level.confidence = confidence;
  level.placing_up = placing;
  return level;
}

Landmarks AxillaLevel(const MeasuredSurface& body, const BodyShape& shape) {
  constexpr std::string_view kId = "level.axilla";
  if (!shape.armpits) return Omitted(kId, "neither arms nor where they begin were seen");
  const Armpits& armpits = *shape.armpits;
  if (armpits.sign == Armpits::Sign::kArms) {
    // Two sides that agree speak for themselves.
    const double confidence = 0.8 * 20.0 / (20.0 + armpits.spread);
    return {
        {LevelAt(kId, Estimate{armpits.z - kGroove, {}}, confidence, std::hypot(kArmpitPlacing, 0.5 * armpits.spread))},
        {}};
  }
  const SectionSampler sampler(body.surface(), EvenDirections(360));
  const HeightFunction breadth = SumOf(ReachOver(sampler, shape.front - kPi / 2.0, kPi / 2.0),
                                       ReachOver(sampler, shape.front + kPi / 2.0, kPi / 2.0));
  const std::optional<Estimate> vertex =
      FindLevelVertex(body.surface(), SlopeOf(breadth, kWideningHalf), armpits.z, kWideningHalf, Extremum::kLargest);
  const double confidence = 0.6 * armpits.steepness / (armpits.steepness + 0.5);
  return {{LevelAt(kId, vertex.value_or(Estimate{armpits.z, {}}), confidence, kStumpPlacing)}, {}};
}

Landmarks ChestByShape(const MeasuredSurface& body, const BodyShape& shape) {
  constexpr std::string_view kId = "level.chest";
  if (!shape.waist) return Omitted(kId, "not found in the part that was seen all around");
  if (!shape.armpits) return Omitted(kId, "the girth only grows from the waist up, and no armpits were seen");
  constexpr double kHalf = 20.0;
  const HeightFunction outline = FrontOutline(body, shape);
  const double low = *shape.waist + 60.0;
  const std::optional<double> forward = InnerMaximum(outline, low, shape.armpits->z);
  if (forward) {
    const std::optional<Estimate> vertex =
        FindLevelVertex(body.surface(), outline, *forward, kHalf, Extremum::kLargest);
    const double depth = vertex ? outline.value(vertex->value) - std::max(outline.value(vertex->value - 2.0 * kHalf),
                                                                          outline.value(vertex->value + 2.0 * kHalf))
                                : 0.0;
    if (depth > 1.0) return {{LevelAt(kId, *vertex, 0.8 * depth / (depth + 2.0), kForwardPlacing)}, {}};
  }
  const double z = shape.armpits->z + 0.23 * (*shape.waist - shape.armpits->z);
  return {{ByProportion(kId, Estimate{z, {}}, kChestByProportion)}, {}};
}

Landmarks UnderBustLevel(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& chest,
                         const Landmarks& waist) {
  constexpr std::string_view kId = "level.under_bust";
  if (chest.found.empty() || waist.found.empty()) return Omitted(kId, "chest or waist level is missing");
  constexpr double kHalf = 15.0;
  const Estimate& top = chest.found.front().z;
  const Estimate& bottom = waist.found.front().z;
  const HeightFunction bend = BendOf(FrontOutline(body, shape), kHalf);
  const std::optional<double> strongest = InnerMaximum(bend, bottom.value + kHalf, top.value - kHalf);
  if (strongest) {
    const std::optional<Estimate> vertex = FindLevelVertex(body.surface(), bend, *strongest, 10.0, Extremum::kLargest);
    const double depth = vertex ? 0.5 * kHalf * kHalf * bend.value(vertex->value) : 0.0;  // mm over a chord of 30 mm
    if (depth > 0.3) return {{LevelAt(kId, *vertex, depth / (depth + 1.0), kBendPlacing)}, {}};
  }
  return {{ByProportion(kId, Combine(0.6, top, 0.4, bottom), kUnderBustByProportion)}, {}};
}

Landmarks OmphalionLevel(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& waist,
                         const Landmarks& hip) {
  constexpr std::string_view kId = "level.omphalion";
  if (waist.found.empty() || hip.found.empty()) return Omitted(kId, "waist or hip level is missing");
  const Estimate& top = waist.found.front().z;
  const Estimate& bottom = hip.found.front().z;
  if (const auto navel = FindNavel(body, shape, top.value, bottom.value)) {
    return {{LevelAt(kId, navel->z, navel->confidence, kNavelPlacing)}, {}};
  }
  return {{ByProportion(kId, Combine(0.75, top, 0.25, bottom), kNavelByProportion)}, {}};
}

Landmarks IliacLevel(const Landmarks& waist, const Landmarks& hip) {
  constexpr std::string_view kId = "level.iliac";
  if (waist.found.empty() || hip.found.empty()) return Omitted(kId, "waist or hip level is missing");
  return {{ByProportion(kId, Combine(0.5, waist.found.front().z, 0.5, hip.found.front().z), kIliacByProportion)}, {}};
}

Landmarks CrotchLevel(const MeasuredSurface& body, const BodyShape& shape) {
  constexpr std::string_view kId = "level.crotch";
  constexpr double kCleft = 0.1;  // of the section's depth, both in front and behind
  if (!shape.hip) return Omitted(kId, "the hip level is missing");
  const double z = shape.lowest;
  const SplineSurface& surface = body.surface();
  const SectionSampler sampler(surface, EvenDirections(360));
  double depth = 0.0;
  double shallower = std::numeric_limits<double>::infinity();
  for (const double toward : {shape.front, shape.front + kPi}) {
    const double reach = ReachOver(sampler, toward, kPi / 2.0).value(z);
    const double middle = MidDirection(body, toward, z);
    depth += reach;
    shallower = std::min(shallower, reach - surface.Radius(middle, z) * std::cos(middle - toward));
  }
  if (shallower < kCleft * depth) return Omitted(kId, "the legs do not part within the part that was seen");
  const double share = shallower / depth;
  const double end = z - surface.z_min() < kGirthStep ? surface.z_min() : z;
  return {{LevelAt(kId, Estimate{end, {}}, share / (share + 0.1), kCrotchPlacing)}, {}};
}

}  // namespace annulus
