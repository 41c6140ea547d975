// Landmarks of a head that come in pairs.

#include <algorithm>
#include <cmath>

#include "base/frames.h"
#include "modeling/landmarks/head_features.h"
#include "modeling/landmarks/surface_vertex.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kProportionConfidence = 0.15;
// Of an eye's centre by its socket: on two heads of people it lay 3 and 9 mm too low.
constexpr double kSocketConfidence = 0.4;
constexpr double kSocketPlacing = 5.0;  // mm
constexpr double kRoughPlacing = 1.0;   // mm; by a ball that skin or noise lies on

/// +1 on the side on which theta grows from the front (the subject's left).
double Turn(BodySide side) { return side == BodySide::kLeft ? 1.0 : -1.0; }

FoundFeature Detected(const SurfaceVertex& vertex) {
  return {vertex.theta, vertex.z, vertex.confidence, LandmarkSource::kDetected};
}

FoundFeature ByProportion(double theta, const Estimate& z) {
  return {{theta, {}}, z, kProportionConfidence, LandmarkSource::kProportion};
}

Estimate Shifted(const Estimate& estimate, double by) { return {estimate.value + by, estimate.gradient}; }

/// Angle under which `length` mm are seen from the axis at a place.
double AngleOf(const HeadView& head, double length, double theta, double z) {
  return length / std::max(head.surface().Radius(theta, z), 20.0);
}

/// A patch of the head, whole degrees and millimetres: angles from the front towards the side.
struct SidePatch {
  double first_turn = 0.0;  ///< rad from the plane's yaw.
  double last_turn = 0.0;
  double low = 0.0;  ///< mm
  double high = 0.0;
};

/// Where the field is largest on a patch; empty if on its border or if the patch leaves the surface.
std::optional<SurfacePlace> LargestInside(const HeadView& head, const SurfaceField& field, const SidePatch& patch,
                                          BodySide side) {
  constexpr double kStepUp = 2.0;
  constexpr double kStepAcross = RadiansFromDegrees(1.0);
  if (patch.low < head.surface().z_min() || patch.high > head.surface().z_max()) return std::nullopt;
  std::optional<SurfacePlace> best;
  double largest = -1e9;
  bool is_inside = false;
  for (double z = patch.low; z <= patch.high; z += kStepUp) {
    for (double turn = patch.first_turn; turn <= patch.last_turn; turn += kStepAcross) {
      const SurfacePlace place{head.plane.yaw + Turn(side) * turn, z};
      const double here = field.At(head.surface(), place);
      if (here <= largest) continue;
      largest = here;
      best = place;
      is_inside = turn > patch.first_turn && turn + kStepAcross <= patch.last_turn &&
                  (patch.low == patch.high || (z > patch.low && z + kStepUp <= patch.high));
    }
  }
  return is_inside ? best : std::nullopt;
}

/// How far a place is turned from the face's direction towards its side, rad.
double TurnOf(const HeadView& head, double theta, BodySide side) {
  return Turn(side) * AngleDifference(theta, head.plane.yaw);
}

/// Where the ear begins, seen from the front, as a turn; of a usual head if it has none.
double EarFrontTurn(const HeadView& head, BodySide side) {
  const std::optional<EarOutline>& ear = head.Ear(side);
  return ear ? TurnOf(head, ear->front_theta, side) : RadiansFromDegrees(85.0);
}

}  // namespace

FoundFeature FindEyeCentre(const HeadView& head, BodySide side) {
  const FacePoint& eye = side == BodySide::kRight ? head.face.eye_right : head.face.eye_left;
  const double theta = std::atan2(eye.position.y(), eye.position.x());
  if (eye.source != LandmarkSource::kDetected) return ByProportion(theta, {eye.position.z(), {}});
  const std::optional<Eyeball>& ball = side == BodySide::kRight ? head.eyeballs.right : head.eyeballs.left;
  if (!ball) {
    return {{theta, {}}, {eye.position.z(), {}}, kSocketConfidence, LandmarkSource::kDetected, kSocketPlacing};
  }
  // lateral = -r(theta, z) sin(theta - yaw) keeps holding where the surface is straight before the ball's centre.
  const EyeballEstimates centre = EstimateEyeball(head.surface(), head.plane, *ball);
  const RadiusJet jet = head.surface().Jet(theta, eye.position.z());
  const double turn = theta - head.plane.yaw;  // 0 ahead, positive to the left
  const double by_theta = -jet.r_theta * std::sin(turn) - jet.r * std::cos(turn);
  GradientSum radius(head.surface());
  radius.AddRadius(theta, eye.position.z(), std::sin(turn));
  const Estimate on_surface = Combine(1.0, {0.0, radius.Get()}, jet.r_z * std::sin(turn), centre.z);
  const Estimate across = Combine(1.0 / by_theta, centre.lateral, 1.0 / by_theta, on_surface);
  return {{theta, across.gradient},
          {eye.position.z(), centre.z.gradient},
          ball->share,
          LandmarkSource::kDetected,
          ball->is_rough ? kRoughPlacing : 0.0};
}

FoundFeature FindOrbitale(const HeadView& head, const FoundFeature& eye, BodySide side) {
  const VertexQuery query{.field = SurfaceField::Along(head.plane.forward()).Fall(0.0, 6.0 * head.scale),
                          .freedom = VertexFreedom::kUp,
                          .half_across = 8.0 * head.scale,
                          .half_up = 7.0 * head.scale};
  const double turn = TurnOf(head, eye.theta.value, side);
  const double low = eye.z.value - 30.0 * head.scale;
  const double high = eye.z.value - 6.0 * head.scale;
  double best = -1e9;
  double best_z = low;
  for (double z = low; z <= high; z += 1.0) {
    const double here = query.field.At(head.surface(), {eye.theta.value, z});
    if (here <= best) continue;
    best = here;
    best_z = z;
  }
  const bool is_inside = best_z > low && best_z + 1.0 <= high && best > 0.0 && turn > 0.0;
  const auto vertex =
      is_inside ? FindVertexAlong(head.surface(), eye.theta, {best_z, {}}, query) : std::optional<SurfaceVertex>();
  if (vertex && vertex->z.value < eye.z.value) return Detected(*vertex);
  return ByProportion(eye.theta.value, Shifted(eye.z, -18.0 * head.scale));
}

Feature FindAlare(const HeadView& head, const FoundFeature& pronasale, BodySide side) {
  const Estimate z = Shifted(pronasale.z, -3.0 * head.scale);
  const double chord = AngleOf(head, 8.0 * head.scale, pronasale.theta.value, z.value);
  const VertexQuery query{.field = SurfaceField::Along(head.plane.forward()).OverChord(chord, 0.0),
                          .shape = VertexShape::kHollow,
                          .freedom = VertexFreedom::kAcross,
                          .half_across = 5.0 * head.scale,
                          .half_up = 4.0 * head.scale};
  double best = 0.0;
  std::optional<double> start;
  for (double across = 8.0; across <= 27.0; across += 0.5) {
    const double turn = Turn(side) * AngleOf(head, across * head.scale, pronasale.theta.value, z.value);
    const double here = query.field.At(head.surface(), {pronasale.theta.value + turn, z.value});
    if (here >= best) continue;
    best = here;
    start = pronasale.theta.value + turn;
  }
  if (!start) return std::nullopt;
  const auto vertex = FindVertexAlong(head.surface(), {*start, {}}, z, query);
  if (!vertex) return std::nullopt;
  return Detected(*vertex);
}

Feature FindTemple(const HeadView& head, const FoundFeature& eye, BodySide side) {
  // 60 degrees from the mid-plane: at 45 the brow or the cheek may stand farther out than the socket's outer rim.
  const Vector3d corner = 0.5 * head.plane.forward() + std::sqrt(0.75) * head.Outward(side);
  const VertexQuery query{.field = SurfaceField::Along(corner),
                          .freedom = VertexFreedom::kAcross,
                          .half_across = 10.0 * head.scale,
                          .half_up = 6.0 * head.scale};
  const SidePatch patch{RadiansFromDegrees(20.0), RadiansFromDegrees(75.0), eye.z.value, eye.z.value};
  const auto start = LargestInside(head, query.field, patch, side);
  if (!start) return std::nullopt;
  const auto vertex = FindVertexAlong(head.surface(), {start->theta, {}}, eye.z, query);
  if (!vertex) return std::nullopt;
  return Detected(*vertex);
}

FoundFeature FindOtobasion(const HeadView& head, BodySide side) {
  const FacePoint& ear = side == BodySide::kRight ? head.face.ear_right : head.face.ear_left;
  const double theta = std::atan2(ear.position.y(), ear.position.x());
  if (!head.Ear(side)) return ByProportion(theta, {ear.position.z(), {}});
  const double clear = head.Ear(side)->height / (head.Ear(side)->height + 8.0);
  return {{theta, {}}, {ear.position.z(), {}}, clear, LandmarkSource::kDetected};
}

FoundFeature FindTragion(const HeadView& head, const FoundFeature& orbitale, BodySide side) {
  constexpr double kBelowTop = 0.45;  // of the ear's height
  const std::optional<EarOutline>& ear = head.Ear(side);
  if (!ear) return ByProportion(head.plane.yaw + Turn(side) * RadiansFromDegrees(88.0), orbitale.z);
  const double z = ear->top_z - kBelowTop * (ear->top_z - ear->bottom_z);
  const double clear = ear->height / (ear->height + 8.0);
  return {{ear->front_theta, {}}, {z, {}}, clear, LandmarkSource::kDetected};
}

Feature FindEuryon(const HeadView& head, BodySide side) {
  const std::optional<EarOutline>& ear = head.Ear(side);
  const double low = ear ? ear->top_z + 10.0 * head.scale : head.face.sellion.position.z() + 25.0 * head.scale;
  VertexQuery query{
      .field = SurfaceField::Along(head.Outward(side)), .half_across = 15.0 * head.scale, .half_up = 15.0 * head.scale};
  const double high = head.surface().z_max() - 16.0 * head.scale;
  const SidePatch patch{RadiansFromDegrees(50.0), RadiansFromDegrees(140.0), low, high};
  if (const auto start = LargestInside(head, query.field, patch, side)) {
    const auto vertex = FindVertex(head.surface(), *start, query);
    if (vertex && vertex->z.value > low - 6.0 * head.scale) return Detected(*vertex);
  }
  // The head widens down to the ears: as broad as it is just above them.
  const SidePatch line{patch.first_turn, patch.last_turn, low + 5.0 * head.scale, low + 5.0 * head.scale};
  const auto start = LargestInside(head, query.field, line, side);
  query.freedom = VertexFreedom::kAcross;
  query.half_up = 5.0 * head.scale;
  const auto vertex = start ? FindVertex(head.surface(), *start, query) : std::optional<SurfaceVertex>();
  if (!vertex) return std::nullopt;
  return FoundFeature{vertex->theta, vertex->z, 0.3, LandmarkSource::kProportion};
}

Feature FindZygion(const HeadView& head, const FoundFeature& tragion, const FoundFeature& orbitale, BodySide side) {
  const double ear_front = std::min(EarFrontTurn(head, side), TurnOf(head, tragion.theta.value, side));
  const double last = ear_front - AngleOf(head, 8.0 * head.scale, tragion.theta.value, tragion.z.value);
  const VertexQuery query{
      .field = SurfaceField::Along(head.Outward(side)), .half_across = 8.0 * head.scale, .half_up = 9.0 * head.scale};
  const SidePatch patch{RadiansFromDegrees(30.0), last, orbitale.z.value - 22.0 * head.scale,
                        orbitale.z.value + 14.0 * head.scale};
  if (const auto start = LargestInside(head, query.field, patch, side)) {
    const auto vertex = FindVertex(head.surface(), *start, query);
    if (vertex && TurnOf(head, vertex->theta.value, side) < ear_front) return Detected(*vertex);
  }
  // The cheek widens back to the ear: where it bulges up and down, 18 mm before the ear.
  const double before = AngleOf(head, 18.0 * head.scale, tragion.theta.value, tragion.z.value);
  const double theta = head.plane.yaw + Turn(side) * (ear_front - before);
  VertexQuery line = query;
  line.freedom = VertexFreedom::kUp;
  const auto vertex = FindVertex(head.surface(), {theta, 0.5 * (patch.low + patch.high)}, line);
  const bool is_near = vertex && vertex->z.value > patch.low && vertex->z.value < patch.high;
  if (is_near) return FoundFeature{{theta, {}}, vertex->z, 0.5 * vertex->confidence, LandmarkSource::kProportion};
  return ByProportion(theta, Combine(0.5, orbitale.z, 0.5, tragion.z));
}

Feature FindGonion(const HeadView& head, const FoundFeature& tragion, const FoundFeature& menton, BodySide side) {
  const VertexQuery query{.field = SurfaceField::Along(head.Outward(side)).OverChord(0.0, 20.0 * head.scale),
                          .half_across = 12.0 * head.scale,
                          .half_up = 9.0 * head.scale};
  // Clear of the ear's lobe, which bulges more than the jaw.
  const std::optional<EarOutline>& ear = head.Ear(side);
  const double front = EarFrontTurn(head, side);
  const double lobe = AngleOf(head, 6.0 * head.scale, tragion.theta.value, tragion.z.value);
  const SidePatch patch{front - RadiansFromDegrees(25.0), front - lobe, menton.z.value - 2.0,
                        ear ? ear->bottom_z - 4.0 * head.scale : tragion.z.value - 35.0 * head.scale};
  const auto start = LargestInside(head, query.field, patch, side);
  const auto vertex = start ? FindVertex(head.surface(), *start, query) : std::optional<SurfaceVertex>();
  if (!vertex || vertex->confidence < 0.5) return std::nullopt;
  const double turn = TurnOf(head, vertex->theta.value, side);
  const bool is_inside =
      turn > patch.first_turn && turn < patch.last_turn && vertex->z.value > patch.low && vertex->z.value < patch.high;
  return is_inside ? Feature(Detected(*vertex)) : std::nullopt;
}

}  // namespace annulus
