#include "modeling/glasses/wearer_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/frames.h"
#include "modeling/landmarks/face_from_landmarks.h"
#include "modeling/landmarks/head_landmarks.h"
#include "modeling/landmarks/head_without_ears.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempt = "look at the head that is to wear the glasses";
/// How far above the eyes and below them glasses reach, mm.
constexpr double kAboveEyes = 90.0;
constexpr double kBelowEyes = 110.0;
/// Monocular pupillary distances outside this are nobody's, mm.
constexpr double kLeastPd = 20.0;
constexpr double kLargestPd = 45.0;
/// A Frankfurt plane steeper than this against the station is a misplaced landmark, rad.
constexpr double kSteepest = RadiansFromDegrees(25.0);
/// sd of the pitch where the landmarks do not show, rad: how people hold their heads.
constexpr double kUsualPitchSigma = RadiansFromDegrees(5.0);

FacePoint* PointByName(FacePoints& face, const std::string& name) {
  for (const NamedFacePoint& named : FacePointNames()) {
    if (named.name == name) return &(face.*named.member);
  }
  return nullptr;
}

/// The covariance of a place that is uncertain along the skin only.
Eigen::Matrix3d AlongSkin(const SplineSurface& surface, const Vector3d& p, double sigma) {
  const Vector3d normal = surface.Normal(std::atan2(p.y(), p.x()), std::clamp(p.z(), surface.z_min(), surface.z_max()));
  return sigma * sigma * (Eigen::Matrix3d::Identity() - normal * normal.transpose());
}

/// The surface's place at a lateral of the mid-plane and a height, near `from`.
Vector3d MovedAlongSkin(const SplineSurface& head, const Vector3d& from, const Vector3d& right, double sideways) {
  Vector3d p = from;
  const double wanted = from.dot(right) + sideways;
  for (int step = 0; step < 30; ++step) {
    const double theta = std::atan2(p.y(), p.x());
    const double miss = wanted - p.dot(right);
    const RadiusJet jet = head.Jet(theta, p.z());
    const Vector3d radial(std::cos(theta), std::sin(theta), 0.0);
    const Vector3d across(-radial.y(), radial.x(), 0.0);
    const double slope = (jet.r_theta * radial + jet.r * across).dot(right);
    if (std::abs(miss) < 1e-9 || std::abs(slope) < 1.0) break;
    p = head.Point(theta + std::clamp(miss / slope, -0.1, 0.1), p.z());
  }
  return p;
}

}  // namespace

const FacePoint& WearerHead::EyePoint(Eye eye) const { return eye == Eye::kRight ? face_.eye_right : face_.eye_left; }

const FacePoint& WearerHead::EarPoint(Eye side) const { return side == Eye::kRight ? face_.ear_right : face_.ear_left; }

Result<WearerHead> WearerHead::Look(const MeasuredSurface& measured, const FaceOverrides& overrides) {
  const SplineSurface& surface = measured.surface();
  if (surface.z_max() - surface.z_min() < kLeastHead) {
    return Fail(kAttempt, fmt::format("the surface is only {:.0f} mm high", surface.z_max() - surface.z_min()),
                "check that the model shows a head");
  }
  const auto found = FindFaceAndEars(surface, HeadGrid(surface, kHeadDepth));
  if (!found) return Fail(found);
  WearerHead head(measured);
  const Landmarks landmarks = FindHeadLandmarks(measured);
  const auto with_covariances = FaceFromLandmarks(landmarks, measured);
  head.face_ = with_covariances ? *with_covariances : found->face;
  head.plane_ = found->plane;
  RETURN_IF_ERROR(head.TakePoints(overrides));
  head.Level(landmarks, overrides);
  RETURN_IF_ERROR(head.TakePupillaryDistances(overrides));
  const double eyes = head.station_from_head_.translation().z();
  if (eyes - surface.z_min() < 30.0 || surface.z_max() - eyes < 20.0) {
    return Fail(kAttempt,
                fmt::format("the surface ends {:.0f} mm above and {:.0f} mm below the eyes", surface.z_max() - eyes,
                            eyes - surface.z_min()),
                "scan the head from above the brow to below the ears");
  }
  head.surface_without_ears_ =
      std::make_shared<const SplineSurface>(HeadWithoutEars(surface, found->ear_right, found->ear_left).surface());
  head.skin_ = std::make_shared<const HeadDistance>(surface, eyes - kBelowEyes, eyes + kAboveEyes);
  head.without_ears_ =
      std::make_shared<const HeadDistance>(*head.surface_without_ears_, eyes - kBelowEyes, eyes + kAboveEyes);
  return head;
}

Status WearerHead::TakePoints(const FaceOverrides& overrides) {
  for (const GivenFacePoint& given : overrides.points) {
    FacePoint* point = PointByName(face_, given.name);
    if (point == nullptr) {
      std::string known;
      for (const NamedFacePoint& named : FacePointNames()) {
        known += (known.empty() ? "" : ", ") + std::string(named.name);
      }
      return Fail(kAttempt, fmt::format("no face point is called '{}'", given.name), "choose one of " + known);
    }
    if (!given.position.allFinite() || !(given.sigma >= 0.0 && given.sigma <= 100.0)) {
      return Fail(kAttempt, fmt::format("{} is given as a place that is not one", given.name),
                  "give x, y and z in mm, and an sd of 0 … 100 mm");
    }
    *point = {given.position, LandmarkSource::kGiven, AlongSkin(measured_->surface(), given.position, given.sigma)};
  }
  const double apart = (eye(Eye::kRight) - eye(Eye::kLeft)).dot(plane_.right());
  if (!(apart > 2.0 * kLeastPd && apart < 2.0 * kLargestPd)) {
    return Fail(kAttempt, fmt::format("the right eye is {:.1f} mm to the right of the left eye", apart),
                "check the eye centres: 40 … 90 mm apart, the right one on the right");
  }
  return {};
}

void WearerHead::Level(const Landmarks& landmarks, const FaceOverrides& overrides) {
  const Vector3d right = Vector3d(plane_.right() - plane_.lean * Vector3d::UnitZ()).normalized();
  const Vector3d level_forward = Vector3d::UnitZ().cross(right).normalized();
  double pitch = 0.0;
  level_sigma_ = kUsualPitchSigma;
  const Landmark* orbitale[] = {landmarks.Find("orbitale_right"), landmarks.Find("orbitale_left")};
  const Landmark* tragion[] = {landmarks.Find("tragion_right"), landmarks.Find("tragion_left")};
  if (orbitale[0] != nullptr && orbitale[1] != nullptr && tragion[0] != nullptr && tragion[1] != nullptr) {
    const Vector3d line =
        0.5 * (orbitale[0]->position + orbitale[1]->position - tragion[0]->position - tragion[1]->position);
    const double length = line.dot(level_forward);
    const double angle = std::atan2(line.z(), length);
    if (length > 30.0 && std::abs(angle) < kSteepest) {
      pitch = angle;
      level_sigma_ =
          std::sqrt(0.5 * (std::pow(orbitale[0]->placing_up, 2) + std::pow(tragion[0]->placing_up, 2))) / length;
    }
  }
  if (overrides.head_tilt) {
    pitch = std::clamp(*overrides.head_tilt, -kSteepest, kSteepest);
    level_sigma_ = 0.0;
  }
  const Vector3d up_before = right.cross(level_forward);
  const Vector3d forward = std::cos(pitch) * level_forward + std::sin(pitch) * up_before;
  station_from_head_.linear() << right, forward, right.cross(forward);
  station_from_head_.translation() = 0.5 * (eye(Eye::kRight) + eye(Eye::kLeft));
  nose_lateral_ = (station_from_head_.inverse() * face_.sellion.position).x();
}

Status WearerHead::TakePupillaryDistances(const FaceOverrides& overrides) {
  const auto take = [&](const std::optional<double>& pd, FacePoint& eye, double sign) -> Status {
    if (!pd) return {};
    if (!(*pd >= kLeastPd && *pd <= kLargestPd)) {
      return Fail(kAttempt, fmt::format("a monocular pupillary distance is {:.1f} mm", *pd),
                  fmt::format("give {:.0f} … {:.0f} mm from the nose's middle", kLeastPd, kLargestPd));
    }
    const Vector3d right = station_from_head_.linear().col(0);
    const double now = (eye.position - face_.sellion.position).dot(right);
    eye.position = MovedAlongSkin(measured_->surface(), eye.position, right, sign * *pd - now);
    eye.source = LandmarkSource::kGiven;
    return {};
  };
  RETURN_IF_ERROR(take(overrides.pd_right, face_.eye_right, 1.0));
  RETURN_IF_ERROR(take(overrides.pd_left, face_.eye_left, -1.0));
  station_from_head_.translation() = 0.5 * (eye(Eye::kRight) + eye(Eye::kLeft));
  nose_lateral_ = (station_from_head_.inverse() * face_.sellion.position).x();
  return {};
}

}  // namespace annulus
