#include "modeling/landmarks/body_levels.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "base/frames.h"
#include "modeling/landmarks/level_vertex.h"
#include "modeling/landmarks/trunk_levels.h"

namespace annulus {
namespace {

constexpr std::size_t kTapeDirections = 360;

/// How a girth's extremum is looked for.
struct GirthLevel {
  const char* id;
  std::optional<double> BodyShape::*coarse;
  Extremum extremum;
  double half;     ///< mm; half the window of the cubic; half of it where that would leave the surface.
  double clear;    ///< mm from the extremum within which nothing else changes the girth.
  double placing;  ///< mm; sd, see docs/landmarks.md.
};
constexpr GirthLevel kHead{"level.head", &BodyShape::head, Extremum::kLargest, 15.0, 15.0, 1.0};
constexpr GirthLevel kNeck{"level.neck", &BodyShape::neck, Extremum::kSmallest, 12.0, 25.0, 1.0};
constexpr GirthLevel kChest{"level.chest", &BodyShape::chest, Extremum::kLargest, 25.0, 30.0, 1.0};
constexpr GirthLevel kWaist{"level.waist", &BodyShape::waist, Extremum::kSmallest, 25.0, 60.0, 1.0};
constexpr GirthLevel kHip{"level.hip", &BodyShape::hip, Extremum::kLargest, 25.0, 60.0, 1.0};

/// By how much the girth falls from its extremum on the side on which it falls less.
double Depth(const SplineSurface& surface, const HeightFunction& tape, double z, const GirthLevel& level) {
  const double sign = level.extremum == Extremum::kLargest ? 1.0 : -1.0;
  double depth = std::numeric_limits<double>::infinity();
  for (const double side : {std::max(z - level.clear, surface.z_min()), std::min(z + level.clear, surface.z_max())}) {
    depth = std::min(depth, sign * (tape.value(z) - tape.value(side)));
  }
  return std::max(0.0, depth);
}

Landmark ExtremumLevel(const MeasuredSurface& body, double coarse, const GirthLevel& level) {
  const SplineSurface& surface = body.surface();
  const SectionSampler sampler(surface, SeenDirections(body, coarse, 2.0 * level.half, kTapeDirections));
  const HeightFunction tape = TapeOver(sampler);
  std::optional<Estimate> vertex = FindLevelVertex(surface, tape, coarse, level.half, level.extremum);
  if (!vertex) vertex = FindLevelVertex(surface, tape, coarse, 0.5 * level.half, level.extremum);
  const double depth = Depth(surface, tape, vertex ? vertex->value : coarse, level);
  constexpr double kClear = 2.0;  // mm of girth
  const double confidence = depth / (depth + kClear);
  // Without a vertex the extremum is a corner or lies beside a step: known as well as the coarse steps are.
  return vertex ? LevelAt(level.id, *vertex, confidence, level.placing)
                : LevelAt(level.id, Estimate{coarse, {}}, 0.5 * confidence, kGirthStep);
}

Landmarks Joined(std::vector<Landmarks> parts) {
  Landmarks all;
  for (Landmarks& part : parts) {
    std::move(part.found.begin(), part.found.end(), std::back_inserter(all.found));
    std::move(part.omitted.begin(), part.omitted.end(), std::back_inserter(all.omitted));
  }
  return all;
}

Landmarks GirthLevelOf(const MeasuredSurface& body, const BodyShape& shape, const GirthLevel& level) {
  const std::optional<double>& coarse = shape.*level.coarse;
  if (coarse) return {{ExtremumLevel(body, *coarse, level)}, {}};
  return {{}, {OmittedText(level.id, "not found in the part that was seen all around")}};
}

}  // namespace

Landmarks FindLevels(const MeasuredSurface& body, const BodyShape& shape) {
  const Landmarks waist = GirthLevelOf(body, shape, kWaist);
  const Landmarks hip = GirthLevelOf(body, shape, kHip);
  const Landmarks chest = shape.chest ? GirthLevelOf(body, shape, kChest) : ChestByShape(body, shape);
  return Joined({GirthLevelOf(body, shape, kHead), GirthLevelOf(body, shape, kNeck), AxillaLevel(body, shape), chest,
                 UnderBustLevel(body, shape, chest, waist), waist, OmphalionLevel(body, shape, waist, hip),
                 IliacLevel(waist, hip), hip, CrotchLevel(body, shape)});
}

}  // namespace annulus
