#include "modeling/table/place_geometry.h"

#include <cmath>
#include <utility>

#include "base/units.h"
#include "modeling/table/measurement_groups.h"

namespace annulus {
namespace {

double ShareMeasured(const MeasuredSurface& body, const Landmark& landmark) {
  return body.KnowledgeAt(landmark.theta.value, landmark.z.value) == Knowledge::kMeasured ? 1.0 : 0.0;
}

RawMeasurement BetweenPoints(const MeasuredSurface& body, const Landmark& a, const Landmark& b) {
  RawMeasurement raw;
  raw.measured_share = 0.5 * (ShareMeasured(body, a) + ShareMeasured(body, b));
  raw.landmarks = {a.id, b.id};
  raw.paths = {{FrameAt(body, PlaceOf(a)).position, FrameAt(body, PlaceOf(b)).position}};
  return raw;
}

}  // namespace

PlaceFrame FrameAt(const MeasuredSurface& body, const SurfacePlace& place) {
  const RadiusJet jet = body.surface().Jet(place.theta, place.z);
  const Eigen::Vector3d outward(std::cos(place.theta), std::sin(place.theta), 0.0);
  const Eigen::Vector3d around(-outward.y(), outward.x(), 0.0);
  return {jet.r * outward + place.z * Eigen::Vector3d::UnitZ(), outward, jet.r_theta * outward + jet.r * around,
          jet.r_z * outward + Eigen::Vector3d::UnitZ()};
}

SurfacePlace PlaceOf(const Landmark& landmark) { return {landmark.theta.value, landmark.z.value}; }

void FollowPoint(RawMeasurement& raw, const MeasuredSurface& body, const Landmark& landmark,
                 const Eigen::Vector3d& derivative) {
  const SurfacePlace place = PlaceOf(landmark);
  GradientSum own(body.surface());
  own.AddRadius(place.theta, place.z, derivative.dot(FrameAt(body, place).by_radius));
  raw.estimate = Combine(1.0, raw.estimate, 1.0, {0.0, own.Get()});
  FollowPlace(raw, body, landmark, derivative);
}

void FollowPlace(RawMeasurement& raw, const MeasuredSurface& body, const Landmark& landmark,
                 const Eigen::Vector3d& derivative) {
  const PlaceFrame frame = FrameAt(body, PlaceOf(landmark));
  // Placing is given along the surface in mm: per mm, theta moves by 1/|P_theta| and z by 1/|P_z|.
  const double across = frame.by_theta.norm();
  Follow(raw, landmark.theta, derivative.dot(frame.by_theta), across > 0.0 ? landmark.placing_across / across : 0.0);
  Follow(raw, landmark.z, derivative.dot(frame.by_z), landmark.placing_up / frame.by_z.norm());
}

RawMeasurement StraightDistance(const MeasuredSurface& body, const Landmark& a, const Landmark& b) {
  RawMeasurement raw = BetweenPoints(body, a, b);
  const Eigen::Vector3d between = raw.paths[0][1] - raw.paths[0][0];
  const double distance = between.norm();
  raw.estimate.value = distance;
  raw.height_share = HeightShare(raw.paths.front());
  const Eigen::Vector3d direction = between.stableNormalized();
  FollowPoint(raw, body, b, direction);
  FollowPoint(raw, body, a, -direction);
  return raw;
}

RawMeasurement SlopeBelowHorizontal(const MeasuredSurface& body, const Landmark& from, const Landmark& to) {
  RawMeasurement raw = BetweenPoints(body, from, to);
  const Eigen::Vector3d between = raw.paths[0][1] - raw.paths[0][0];
  const double along = between.head<2>().norm();
  const double square = between.squaredNorm();
  raw.estimate.value = DegreesFromRadians(std::atan2(-between.z(), along));
  if (square > 0.0 && along > 0.0) {
    Eigen::Vector3d derivative;  // of the angle by the position of `to`, deg/mm
    derivative << between.head<2>() * (between.z() / (along * square)), -along / square;
    derivative *= DegreesFromRadians(1.0);
    raw.height_share = derivative.z() * between.z();
    FollowPoint(raw, body, to, derivative);
    FollowPoint(raw, body, from, -derivative);
  }
  return raw;
}

void AddDistances(MeasurementList& list, std::span<const DistanceRow> rows) {
  for (const DistanceRow& row : rows) {
    const Landmark* a = list.Find(row.a);
    const Landmark* b = list.Find(row.b);
    if (a == nullptr || b == nullptr) continue;
    list.Add({row.id, row.term, "Straight distance from " + a->term + " to " + b->term + ".", "straight line", "mm",
              row.limit},
             StraightDistance(list.body(), *a, *b));
  }
}

}  // namespace annulus
