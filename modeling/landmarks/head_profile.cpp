// Landmarks in the mid-plane of a head.

#include <algorithm>
#include <cmath>

#include "base/frames.h"
#include "modeling/landmarks/head_features.h"
#include "modeling/landmarks/surface_vertex.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kSearchStep = 1.0;  // mm
constexpr double kProportionConfidence = 0.15;

FoundFeature Detected(const SurfaceVertex& vertex) {
  return {vertex.theta, vertex.z, vertex.confidence, LandmarkSource::kDetected};
}

FoundFeature ByProportion(double theta, double z) {
  return {{theta, {}}, {z, {}}, kProportionConfidence, LandmarkSource::kProportion};
}

double WithinHeights(const HeadView& head, double z) {
  return std::clamp(z, head.surface().z_min(), head.surface().z_max());
}

/// The vertex along the front mid profile: at the plane's theta, which follows z.
std::optional<SurfaceVertex> FrontVertex(const HeadView& head, double z, VertexQuery query) {
  query.freedom = VertexFreedom::kUp;
  std::optional<SurfaceVertex> vertex;
  for (int k = 0; k < 3; ++k) {
    vertex = FindVertex(head.surface(), {head.plane.FrontTheta(head.surface(), z), z}, query);
    if (!vertex) return std::nullopt;
    z = vertex->z.value;
  }
  return vertex;
}

/// Where the field is largest on the front mid profile, inside [low, high]; empty if at an end of it.
std::optional<double> LargestInside(const HeadView& head, const SurfaceField& field, double low, double high) {
  const auto value = [&](double z) { return field.At(head.surface(), {head.plane.FrontTheta(head.surface(), z), z}); };
  if (!(low >= head.surface().z_min() && high <= head.surface().z_max() && low < high)) return std::nullopt;
  double best_z = low;
  double best = value(low);
  for (double z = low + kSearchStep; z <= high; z += kSearchStep) {
    const double here = value(z);
    if (here <= best) continue;
    best = here;
    best_z = z;
  }
  if (best_z <= low || best_z + kSearchStep > high) return std::nullopt;
  return best_z;
}

}  // namespace

FoundFeature FindPronasale(const HeadView& head) {
  const Vector3d& tip = head.face.pronasale.position;
  const double theta = std::atan2(tip.y(), tip.x());
  const VertexQuery query{
      .field = SurfaceField::Along(head.plane.forward()), .half_across = 6.0 * head.scale, .half_up = 6.0 * head.scale};
  const auto vertex = FindVertex(head.surface(), {theta, tip.z()}, query);
  if (vertex) return Detected(*vertex);
  return {{theta, {}}, {tip.z(), {}}, 0.3, LandmarkSource::kDetected};
}

FoundFeature FindSellion(const HeadView& head) {
  const Vector3d& root = head.face.sellion.position;
  if (head.face.sellion.source == LandmarkSource::kProportion) {
    return ByProportion(std::atan2(root.y(), root.x()), root.z());
  }
  VertexQuery query{.field = SurfaceField::Along(head.plane.forward()),
                    .shape = VertexShape::kRidgeHollow,
                    .half_across = 6.0 * head.scale,
                    .half_up = 7.0 * head.scale};
  const double theta = head.plane.FrontTheta(head.surface(), root.z());
  if (const auto vertex = FindVertex(head.surface(), {theta, root.z()}, query)) return Detected(*vertex);
  if (const auto vertex = FrontVertex(head, root.z(), query)) return Detected(*vertex);
  // A root that never comes back forwards (a straight forehead): where it lies deepest under a chord.
  query.field = query.field.OverChord(0.0, 20.0 * head.scale);
  if (const auto vertex = FrontVertex(head, root.z(), query)) return Detected(*vertex);
  return {{theta, {}}, {root.z(), {}}, 0.3, LandmarkSource::kDetected};
}

FoundFeature FindGlabella(const HeadView& head, const FoundFeature& sellion) {
  const double low = WithinHeights(head, sellion.z.value + 6.0 * head.scale);
  const double high = WithinHeights(head, sellion.z.value + 38.0 * head.scale);
  VertexQuery query{.field = SurfaceField::Along(head.plane.forward()),
                    .half_across = 10.0 * head.scale,
                    .half_up = 8.0 * head.scale};
  for (const SurfaceField& field : {query.field, query.field.OverChord(0.0, 15.0 * head.scale)}) {
    const auto start = LargestInside(head, field, low, high);
    query.field = field;
    const auto vertex = start ? FrontVertex(head, *start, query) : std::nullopt;
    if (vertex && vertex->z.value > low - 4.0 && vertex->z.value < high + 4.0) return Detected(*vertex);
  }
  const double z = WithinHeights(head, sellion.z.value + 15.0 * head.scale);
  return ByProportion(head.plane.FrontTheta(head.surface(), z), z);
}

Feature FindMenton(const HeadView& head, const FoundFeature& pronasale) {
  constexpr double kLeastDrop = 5.0;  // mm, behind the chin
  const Vector3d downward = (head.plane.forward() - Vector3d::UnitZ()).normalized();
  const VertexQuery query{.field = SurfaceField::Along(downward), .half_across = 10.0, .half_up = 6.0};
  const double high = pronasale.z.value - 28.0 * head.scale;
  const double low = std::max(pronasale.z.value - 120.0 * head.scale, head.surface().z_min());
  double best = -1e9;
  double best_z = high;
  for (double z = high; z >= low; z -= kSearchStep) {
    const double here = query.field.At(head.surface(), {head.plane.FrontTheta(head.surface(), z), z});
    if (here > best) {
      best = here;
      best_z = z;
    }
    if (best - here < kLeastDrop) continue;
    const auto vertex = FrontVertex(head, best_z, query);
    if (!vertex) return std::nullopt;
    return Detected(*vertex);
  }
  return std::nullopt;
}

Feature FindOpisthocranion(const HeadView& head, const FoundFeature& sellion) {
  const double low = sellion.z.value - 35.0 * head.scale;
  const double high = head.surface().z_max() - 16.0;
  const Vector3d back = -head.plane.forward();
  VertexQuery query{.field = SurfaceField::Along(back),
                    .freedom = VertexFreedom::kUp,
                    .half_across = 15.0 * head.scale,
                    .half_up = 15.0 * head.scale};
  double best = -1e9;
  double best_z = low;
  for (double z = low; z <= high; z += kSearchStep) {
    const double here = query.field.At(head.surface(), {head.plane.BackTheta(head.surface(), z), z});
    if (here <= best) continue;
    best = here;
    best_z = z;
  }
  if (best_z <= low || best_z + kSearchStep > high) return std::nullopt;
  const double theta = head.plane.BackTheta(head.surface(), best_z);
  const auto vertex = FindVertex(head.surface(), {theta, best_z}, query);
  if (!vertex) return std::nullopt;
  return Detected(*vertex);
}

Feature FindVertexLevel(const HeadView& head) {
  constexpr double kBelow = 8.0;      // mm between the two sections
  constexpr double kFarthest = 20.0;  // mm above the uppermost one
  constexpr int kDirections = 180;
  const SplineSurface& surface = head.surface();
  const auto is_known = [&](double z) {
    int known = 0;
    for (int k = 0; k < kDirections; ++k) {
      if (head.body.KnowledgeAt(kTwoPi * k / kDirections, z) != Knowledge::kUnknown) ++known;
    }
    return known > 0.95 * kDirections;
  };
  double top = surface.z_max();
  while (top > surface.z_max() - 40.0 && !is_known(top - 0.5)) top -= 1.0;
  // The section's area over pi falls linearly towards the crown of a paraboloid, wherever that lies.
  const auto square = [&](double z) {
    GradientSum sum(surface);
    double mean = 0.0;
    for (int k = 0; k < kDirections; ++k) {
      const double theta = kTwoPi * k / kDirections;
      const double r = surface.Radius(theta, z);
      mean += r * r / kDirections;
      sum.AddRadius(theta, z, 2.0 * r / kDirections);
    }
    return Estimate{mean, sum.Get()};
  };
  const Estimate upper = square(top);
  const Estimate lower = square(top - kBelow);
  const double difference = lower.value - upper.value;
  const double added = kBelow * upper.value / difference;
  if (!(difference > 0.0) || added > kFarthest) return std::nullopt;
  // added = kBelow · upper / (lower − upper).
  const double by_upper = kBelow * lower.value / (difference * difference);
  const double by_lower = -kBelow * upper.value / (difference * difference);
  Estimate z = Combine(by_upper, upper, by_lower, lower);
  z.value = top + added;
  return FoundFeature{{head.plane.yaw, {}}, z, 1.0 - added / (kFarthest + 5.0), LandmarkSource::kDetected};
}

}  // namespace annulus
