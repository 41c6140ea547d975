#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "modeling/glasses/fit_report.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr PointDensity kMapDensity{8, 6};
constexpr double kExactWithin = 30.0;  // mm
constexpr double kExactWithinRanking = 3.0;
constexpr double kNear = 0.5;         // mm; a part as near as this is looked at more finely
constexpr double kRestLength = 30.0;  // mm before the ear point that rest on ear and head
constexpr double kFriction = 0.3;     // of pads on skin
constexpr double kGravity = 9.81e-3;  // N per gram

std::size_t SideOf(const Vector3d& p_in_frame) { return p_in_frame.x() > 0.0 ? 0 : 1; }

/// Points on the back of the lenses.
void AddLensPoints(const FittedFrame& fitted, const WornPose& pose, SkinReport& report) {
  const bool is_full = fitted.options->detail == FitDetail::kFull;
  for (std::size_t side = 0; side < 2; ++side) {
    const char* const part = side == 0 ? "lens_right" : "lens_left";
    const LensPlane& lens = fitted.front.lenses[side];
    const double back = fitted.problem.task().inputs.lens_back[side];
    for (const double share : {0.0, 0.3, 0.6, 0.85, 1.0}) {
      for (std::size_t k = 0; k < lens.outline.size(); k += share == 0.0 ? lens.outline.size() : 4) {
        const Eigen::Vector2d at = share * lens.outline[k];
        const Vector3d p = lens.centre + at.x() * lens.right + at.y() * lens.up - back * lens.forward;
        const double distance = pose.Nearest(p).distance;
        if (is_full) report.map.push_back({part, pose.station_from_frame * p, distance});
        report.rims = std::min(report.rims, distance);
        if (-distance > report.penetration) report.deepest = part;
        report.penetration = std::max(report.penetration, -distance);
        report.front_penetration = std::max(report.front_penetration, -distance);
      }
    }
  }
}

FrameContact ContactAt(const WornPose& pose, const SkinPlace& place, std::string part) {
  const HeadDistance& obstacle = pose.Obstacle(place.position);
  const NearestOnHead foot = obstacle.Nearest(pose.station_from_frame * place.position);
  FrameContact contact;
  contact.part = std::move(part);
  contact.position = foot.position;
  contact.normal = obstacle.surface().Normal(foot.theta, foot.z);
  contact.distance = place.distance;
  return contact;
}

}  // namespace

WornPose WornPoseOf(const FittedFrame& fitted) {
  WornPose pose;
  pose.head = fitted.head;
  pose.station_from_frame = fitted.worn.station_from_frame;
  pose.ear_y_right = fitted.worn.adjustment.temple_right.ear.y();
  pose.ear_y_left = fitted.worn.adjustment.temple_left.ear.y();
  return pose;
}

SkinReport MeasureSkin(const FittedFrame& fitted) {
  const bool is_full = fitted.options->detail == FitDetail::kFull;
  const FrameSkin skin(fitted.shells);
  const WornPose pose = WornPoseOf(fitted);
  const std::vector<SkinPlace> places = skin.Measure(pose, kMapDensity, is_full ? kExactWithin : kExactWithinRanking);
  const auto role = [&](const SkinPlace& place) { return skin.parts()[place.part].role; };
  SkinReport report;
  for (std::size_t k = 0; is_full && k < places.size(); ++k) {
    const SkinPlace& place = places[k];
    report.map.push_back({skin.parts()[place.part].name, pose.station_from_frame * place.position, place.distance});
  }
  for (std::size_t part = 0; part < skin.parts().size(); ++part) {
    const SkinPlace least = skin.Least(pose, kMapDensity, places, [&](const SkinPlace& place) {
      return place.part == part && place.distance < kNear;
    });
    if (-least.distance > report.penetration) report.deepest = skin.parts()[part].name;
    report.penetration = std::max(report.penetration, -least.distance);
    if (skin.parts()[part].role == FrameRole::kTemple && least.distance < 0.0) {
      double& enters = report.temple_penetration[SideOf(least.position)];
      enters = std::max(enters, -least.distance);
    }
    const FrameRole part_role = skin.parts()[part].role;
    const bool is_bent =
        part_role == FrameRole::kTemple || part_role == FrameRole::kPad || part_role == FrameRole::kPadArm;
    if (!is_bent) report.front_penetration = std::max(report.front_penetration, -least.distance);
  }
  const double nasal = 0.5 * fitted.front.design.bridge_gap() + 0.35 * fitted.front.design.parameters.width;
  report.rims = skin.Least(pose, kMapDensity, places,
                           [&](const SkinPlace& place) {
                             const bool is_side = role(place) == FrameRole::kRim || role(place) == FrameRole::kEndPiece;
                             return is_side && std::abs(place.position.x()) > nasal;
                           })
                    .distance;
  AddLensPoints(fitted, pose, report);
  const bool has_pads = fitted.front.design.details.pads != PadForm::kNone;
  for (std::size_t side = 0; side < 2; ++side) {
    report.nose[side] = skin.Least(pose, kMapDensity, places, [&](const SkinPlace& place) {
      const bool bears =
          has_pads ? role(place) == FrameRole::kPad : MayBear(fitted.front.design, role(place), place.position);
      return SideOf(place.position) == side && bears;
    });
    const double ear_y = side == 0 ? pose.ear_y_right : pose.ear_y_left;
    report.temples[side] = skin.Least(pose, kMapDensity, places, [&](const SkinPlace& place) {
      return role(place) == FrameRole::kTemple && SideOf(place.position) == side &&
             place.position.y() > ear_y - kBehindEar && place.position.y() < ear_y + kRestLength;
    });
  }
  return report;
}

void AddBalance(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit) {
  const WornPose pose = WornPoseOf(fitted);
  WeightBalance& balance = fit.balance;
  Vector3d moment = Vector3d::Zero();
  if (fitted.mass) {
    balance.frame_g = fitted.mass->mass;
    moment = fitted.mass->mass * fitted.mass->centre_of_gravity;
  } else {
    // For ranking what overlaps counts twice.
    for (const FrameShell& shell : fitted.shells) {
      const ShellMoments moments = MomentsOf(shell.shell);
      const double grams_per_mm3 = 1e-3 * fitted.options->frame_density;
      balance.frame_g += grams_per_mm3 * moments.volume;
      moment += grams_per_mm3 * moments.first;
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    balance.lenses_g += fitted.options->lens_mass_g[side];
    moment += fitted.options->lens_mass_g[side] * fitted.front.lenses[side].centre;
  }
  const double mass = balance.frame_g + balance.lenses_g;
  const Vector3d centre = mass > 0.0 ? Vector3d(moment / mass) : Vector3d::Zero();
  balance.centre_of_gravity = pose.station_from_frame * centre;
  const bool has_pads = fitted.front.design.details.pads != PadForm::kNone;
  const std::array<const char*, 2> nose_names = has_pads ? std::array<const char*, 2>{"pad_right", "pad_left"}
                                                         : std::array<const char*, 2>{"bridge_right", "bridge_left"};
  std::vector<FrameContact> contacts;
  for (std::size_t side = 0; side < 2; ++side) contacts.push_back(ContactAt(pose, skin.nose[side], nose_names[side]));
  contacts.push_back(ContactAt(pose, skin.temples[0], "temple_right"));
  contacts.push_back(ContactAt(pose, skin.temples[1], "temple_left"));
  // Moments about the line through the rests on the ears; forces across the nose are in balance.
  const Vector3d forward = fitted.head->station_from_head().linear().col(1);
  const Vector3d right = fitted.head->station_from_head().linear().col(0);
  const double ears = 0.5 * (contacts[2].position + contacts[3].position).dot(forward);
  const double nose = 0.5 * (contacts[0].position + contacts[1].position).dot(forward);
  balance.nose_share = std::clamp((balance.centre_of_gravity.dot(forward) - ears) / (nose - ears), 0.0, 1.0);
  const double push_right = std::abs(contacts[0].normal.dot(right));
  const double push_left = std::abs(contacts[1].normal.dot(right));
  balance.right_share = push_right + push_left > 1e-6 ? push_left / (push_right + push_left) : 0.5;
  const double across = (contacts[2].position - contacts[3].position).dot(right);
  const double right_ear = std::clamp((balance.centre_of_gravity - contacts[3].position).dot(right) / across, 0.0, 1.0);
  contacts[0].load_share = balance.nose_share * balance.right_share;
  contacts[1].load_share = balance.nose_share * (1.0 - balance.right_share);
  contacts[2].load_share = (1.0 - balance.nose_share) * right_ear;
  contacts[3].load_share = (1.0 - balance.nose_share) * (1.0 - right_ear);
  const FrameDetails& details = fitted.front.design.details;
  for (std::size_t side = 0; has_pads && side < 2; ++side) {
    // The flank carries its load by the upward part of its push and by friction.
    const double up = std::abs(contacts[side].normal.z());
    const double carries = up + kFriction * std::sqrt(1.0 - up * up);
    const double force = kGravity * mass * contacts[side].load_share / carries;
    contacts[side].pressure_kpa = 1e3 * force / (0.25 * kPi * details.pad_length * details.pad_width);
  }
  fit.contacts = std::move(contacts);
}

}  // namespace annulus
