#include "modeling/landmarks/face_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/frames.h"
#include "modeling/landmarks/ear_outline.h"
#include "modeling/landmarks/head_without_ears.h"
#include "modeling/landmarks/weighted_mean.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempt = "find the face points";
constexpr const char* kAdvice =
    "check that the model shows a head that faces +y (theta 90 degrees), or enter the points";

/// The tip on the surface: most forward near the grid's maximum, halfway between the flanks 3 mm behind it.
FacePoint RefinePronasale(const SplineSurface& head, const HeadGrid& grid, const GridPlace& nose) {
  constexpr double kStep = 0.25;
  const double theta = RadiansFromDegrees(nose.degree);
  double z = grid.z(nose.row);
  for (double dz = -6.0; dz <= 6.0; dz += kStep) {
    const double moved = std::clamp(grid.z(nose.row) + dz, head.z_min(), head.z_max());
    if (head.Point(theta, moved).y() > head.Point(theta, z).y()) z = moved;
  }
  const double flank = head.Radius(theta, z) - 3.0;
  const auto reach = [&](double sign) {
    double angle = 0.0;
    while (angle < RadiansFromDegrees(20.0) && head.Radius(theta + sign * angle, z) > flank) angle += 0.001;
    return angle;
  };
  return {head.Point(theta + 0.5 * (reach(1.0) - reach(-1.0)), z), LandmarkSource::kDetected};
}

/// The hollow of the mid profile above the nose: its first minimum, else where it lies deepest under the chord from the
/// tip to the forehead, else by proportion.
FacePoint FindSellion(const SplineSurface& head, const Vector3d& tip) {
  constexpr double kStep = 0.25;
  constexpr double kChord = 70.0;
  constexpr double kUsual = 33.0;
  const double theta = std::atan2(tip.y(), tip.x());
  const double tip_z = tip.z();
  const auto radius = [&](double above) { return head.Radius(theta, std::min(tip_z + above, head.z_max())); };
  double deepest = 0.0;
  double chord_place = kUsual;
  for (double above = 10.0; above <= 62.0; above += kStep) {
    const bool is_minimum = radius(above) <= radius(above - kStep) && radius(above) < radius(above + kStep);
    // Noise makes shallow minima: a real one has a forehead that comes forward again.
    if (is_minimum && radius(above + 8.0) > radius(above) + 0.3 && radius(above - 8.0) > radius(above) + 0.3) {
      return {head.Point(theta, tip_z + above), LandmarkSource::kDetected};
    }
    const double chord = radius(0.0) + (radius(kChord) - radius(0.0)) * above / kChord;
    if (chord - radius(above) > deepest) {
      deepest = chord - radius(above);
      chord_place = above;
    }
  }
  if (deepest >= 1.0) return {head.Point(theta, tip_z + chord_place), LandmarkSource::kDetected};
  return {head.Point(theta, std::min(tip_z + kUsual, head.z_max())), LandmarkSource::kProportion};
}

/// The point of the nose's ridge at a point's height: halfway between the flanks 2 mm behind the most forward place.
FacePoint OnTheRidge(const SplineSurface& head, const MidPlane& plane, const FacePoint& near) {
  constexpr double kBehind = 2.0;
  constexpr double kReach = RadiansFromDegrees(7.0);
  constexpr double kStep = RadiansFromDegrees(0.05);
  if (near.source == LandmarkSource::kProportion) return near;
  const double z = near.position.z();
  const Vector3d forward = plane.forward();
  const double middle = std::atan2(near.position.y(), near.position.x());
  const auto ahead = [&](double theta) { return forward.dot(head.Point(theta, z)); };
  double crest = middle;
  for (double turn = -0.5 * kReach; turn <= 0.5 * kReach; turn += kStep) {
    if (ahead(middle + turn) > ahead(crest)) crest = middle + turn;
  }
  const double flank = ahead(crest) - kBehind;
  const auto reach = [&](double sign) {
    double turn = 0.0;
    while (turn < kReach && ahead(crest + sign * turn) > flank) turn += kStep;
    return turn;
  };
  const double right = reach(-1.0);
  const double left = reach(1.0);
  if (right >= kReach || left >= kReach) return near;  // no ridge: as flat as a forehead
  return {head.Point(crest + 0.5 * (left - right), z), near.source};
}

/// Where, in front, the surface at height z is `lateral` mm from the mid-plane: theta by bisection, as the lateral
/// falls with theta there.
Vector3d SurfaceAtLateral(const SplineSurface& head, const MidPlane& plane, double lateral, double z) {
  double low = plane.yaw - RadiansFromDegrees(70.0);
  double high = plane.yaw + RadiansFromDegrees(70.0);
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (plane.Lateral(head.Point(middle, z)) > lateral ? low : high) = middle;
  }
  return head.Point(0.5 * (low + high), z);
}

/// The eye's centre where no ball shows, from the hollow of its socket: how far the surface lies behind a vertical
/// chord of 40 mm. The hollow is deepest at the nose, so its place beside the root is the centre of its extent (weights
/// cut off) and z that of its depth.
FacePoint EyeInItsSocket(const SplineSurface& head, const HeadGrid& grid, const FaceAndEars& found, BodySide side) {
  const Vector3d& sellion = found.face.sellion.position;
  const MidPlane& plane = found.plane;
  const double root = plane.Lateral(sellion);
  constexpr int kHalfChord = 20;
  constexpr double kInnermost = 14.5;
  constexpr double kOutermost = 55.0;
  constexpr double kUsualLateral = 31.5;
  constexpr double kUsualBelow = 7.0;
  const double sign = side == BodySide::kRight ? 1.0 : -1.0;
  const auto middle = static_cast<int>(std::lround(DegreesFromRadians(plane.yaw)));
  WeightedMean across;
  WeightedMean height;
  for (int row = grid.RowAt(sellion.z() + 8.0); row <= grid.RowAt(sellion.z() - 27.0); ++row) {
    for (int degree = middle - 60; degree <= middle + 60; ++degree) {
      const double lateral = sign * (plane.Lateral(grid.Point(degree, row)) - root);
      if (lateral < kInnermost || lateral > kOutermost) continue;
      const double hollow =
          0.5 * (grid.r(degree, row - kHalfChord) + grid.r(degree, row + kHalfChord)) - grid.r(degree, row);
      across.Add(std::clamp(hollow - 1.5, 0.0, 4.0), lateral);
      const double deep = std::max(hollow - 3.0, 0.0);
      height.Add(deep * deep, grid.z(row));
    }
  }
  const bool shows = across.weight > 300.0 && height.weight > 300.0 && across.value() > 22.0 && across.value() < 42.0;
  const double lateral = shows ? across.value() : kUsualLateral;
  const double z = shows ? height.value() : sellion.z() - kUsualBelow;
  return {SurfaceAtLateral(head, plane, root + sign * lateral, z),
          shows ? LandmarkSource::kDetected : LandmarkSource::kProportion};
}

/// Straight before the eyeball's centre, as the pupil of an eye that looks at the horizon.
FacePoint FindEye(const SplineSurface& head, const HeadGrid& grid, const FaceAndEars& found, BodySide side) {
  const std::optional<Eyeball>& ball = side == BodySide::kRight ? found.eyeballs.right : found.eyeballs.left;
  if (!ball) return EyeInItsSocket(head, grid, found, side);
  return {SurfaceAtLateral(head, found.plane, found.plane.Lateral(ball->centre), ball->centre.z()),
          LandmarkSource::kDetected};
}

/// The top of the ear, where the temple lies between ear and head; by proportion if there is no ear.
FacePoint EarPoint(const SplineSurface& head, const std::optional<EarOutline>& ear, const Vector3d& sellion,
                   BodySide side) {
  constexpr double kUsualForward = -4.0;
  constexpr double kUsualBelow = 2.0;
  if (!ear) {
    const double degrees = side == BodySide::kRight ? kUsualForward : 180.0 - kUsualForward;
    return {head.Point(RadiansFromDegrees(degrees), sellion.z() - kUsualBelow), LandmarkSource::kProportion};
  }
  return {PointFromCylindrical(ear->top_theta, ear->top_radius, ear->top_z), LandmarkSource::kDetected};
}

}  // namespace

const std::vector<NamedFacePoint>& FacePointNames() {
  static const std::vector<NamedFacePoint> names{
      {"eye_right", &FacePoints::eye_right}, {"eye_left", &FacePoints::eye_left}, {"ear_right", &FacePoints::ear_right},
      {"ear_left", &FacePoints::ear_left},   {"forehead", &FacePoints::forehead}, {"sellion", &FacePoints::sellion},
      {"pronasale", &FacePoints::pronasale}};
  return names;
}

FacePoint ForeheadAbove(const SplineSurface& head, const FacePoint& sellion) {
  constexpr double kAboveSellion = 30.0;
  constexpr double kSlightlyBefore = 2.0;
  const Vector3d& root = sellion.position;
  const double z = std::min(root.z() + kAboveSellion, head.z_max());
  const Vector3d on_skin = head.Point(std::atan2(root.y(), root.x()), z);
  return {on_skin + Vector3d(0.0, kSlightlyBefore, 0.0), LandmarkSource::kDetected, sellion.covariance};
}

Result<FacePoints> FindFacePoints(const SplineSurface& head) {
  if (head.z_max() - head.z_min() < kLeastHead) {
    return Fail(kAttempt, fmt::format("the surface is only {:.0f} mm high", head.z_max() - head.z_min()), kAdvice);
  }
  auto found = FindFaceAndEars(head, HeadGrid(head, kHeadDepth));
  if (!found) return Fail(found);
  return found->face;
}

Result<FaceAndEars> FindFaceAndEars(const SplineSurface& head, const HeadGrid& grid) {
  const std::optional<GridPlace> nose = FindNose(grid, NeckRow(grid));
  if (!nose) {
    return Fail(kAttempt,
                fmt::format("nothing like a nose at the front between z = {:.0f} and {:.0f} mm",
                            head.z_max() - kNoseLowest, head.z_max() - kNoseHighest),
                kAdvice);
  }
  FaceAndEars found;
  FacePoints& face = found.face;
  face.pronasale = RefinePronasale(head, grid, *nose);
  found.plane = FindMidPlane(grid, face.pronasale.position);
  face.sellion = OnTheRidge(head, found.plane, FindSellion(head, face.pronasale.position));
  const Vector3d& sellion = face.sellion.position;
  found.eyeballs = FindEyeballs(head, grid, found.plane, sellion);
  face.eye_right = FindEye(head, grid, found, BodySide::kRight);
  face.eye_left = FindEye(head, grid, found, BodySide::kLeft);
  found.ear_right = FindEarOutline(grid, BodySide::kRight, sellion.z() + kEarHighest, sellion.z() - kEarLowest);
  found.ear_left = FindEarOutline(grid, BodySide::kLeft, sellion.z() + kEarHighest, sellion.z() - kEarLowest);
  const HeadWithoutEars beneath(head, found.ear_right, found.ear_left);
  for (std::optional<EarOutline>* ear : {&found.ear_right, &found.ear_left}) {
    if (*ear) *ear = WithTopOnTheHead(**ear, beneath);
  }
  face.ear_right = EarPoint(head, found.ear_right, sellion, BodySide::kRight);
  face.ear_left = EarPoint(head, found.ear_left, sellion, BodySide::kLeft);
  face.forehead = ForeheadAbove(head, face.sellion);
  return found;
}

}  // namespace annulus
