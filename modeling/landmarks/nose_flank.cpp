#include "modeling/landmarks/nose_flank.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kAcrossStep = 0.25;  // mm
constexpr double kFarthest = 26.0;    // mm, beside the ridge: no nose is broader
constexpr double kNearest = 5.0;      // mm, beside the ridge, where a furrow may be
constexpr double kHalfChord = 6.0;    // mm
constexpr double kBehindCrest = 2.0;  // mm
constexpr double kLeastNose = 3.0;    // mm

/// One horizontal section in the head's own directions.
class Section {
 public:
  Section(const SplineSurface& head, const MidPlane& plane, double z)
      : head_(head), plane_(plane), forward_(plane.forward()), z_(z) {}

  /// Theta where the section is `lateral` mm beside the mid-plane in front: by bisection, as it falls with theta there.
  [[nodiscard]] double Theta(double lateral) const {
    double low = plane_.yaw - RadiansFromDegrees(50.0);
    double high = plane_.yaw + RadiansFromDegrees(50.0);
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (plane_.Lateral(head_.Point(middle, z_)) > lateral ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
  [[nodiscard]] Vector3d At(double lateral) const { return head_.Point(Theta(lateral), z_); }
  [[nodiscard]] double Ahead(double lateral) const { return forward_.dot(At(lateral)); }

 private:
  const SplineSurface& head_;
  const MidPlane& plane_;
  Vector3d forward_;
  double z_;
};

/// Forward coordinates of a section at laterals of equal distance.
struct Profile {
  double first = 0.0;
  std::vector<double> ahead;
  [[nodiscard]] double lateral(std::size_t k) const { return first + kAcrossStep * static_cast<double>(k); }
};

Profile Sample(const Section& section, double middle) {
  constexpr double kReach = kFarthest + kHalfChord;
  Profile profile{middle - kReach, {}};
  for (double lateral = middle - kReach; lateral <= middle + kReach; lateral += kAcrossStep) {
    profile.ahead.push_back(section.Ahead(lateral));
  }
  return profile;
}

/// Halfway between the flanks just behind the most forward place near the middle.
std::optional<double> CrestOf(const Profile& profile, double middle) {
  constexpr double kBeside = 6.0;
  std::size_t crest = 0;
  for (std::size_t k = 0; k < profile.ahead.size(); ++k) {
    if (std::abs(profile.lateral(k) - middle) > kBeside) continue;
    if (crest == 0 || profile.ahead[k] > profile.ahead[crest]) crest = k;
  }
  const double level = profile.ahead[crest] - kBehindCrest;
  std::size_t low = crest;
  std::size_t high = crest;
  while (low > 0 && profile.ahead[low] > level) --low;
  while (high + 1 < profile.ahead.size() && profile.ahead[high] > level) ++high;
  if (profile.ahead[low] > level || profile.ahead[high] > level) return std::nullopt;
  // Linear within the last step of either side.
  const auto share = [&](std::size_t inside, std::size_t outside) {
    return (profile.ahead[inside] - level) / (profile.ahead[inside] - profile.ahead[outside]);
  };
  const double left = profile.lateral(low + 1) - kAcrossStep * share(low + 1, low);
  const double right = profile.lateral(high - 1) + kAcrossStep * share(high - 1, high);
  return 0.5 * (left + right);
}

/// Where the section is most hollow beside the crest; sign +1 is the right side.
double ValleyOf(const Profile& profile, double crest, double sign) {
  const auto chord = static_cast<std::size_t>(std::lround(kHalfChord / kAcrossStep));
  double deepest = -1e9;
  double valley = crest + sign * kNearest;
  for (std::size_t k = chord; k + chord < profile.ahead.size(); ++k) {
    const double beside = sign * (profile.lateral(k) - crest);
    if (beside < kNearest || beside > kFarthest) continue;
    const double hollow = 0.5 * (profile.ahead[k - chord] + profile.ahead[k + chord]) - profile.ahead[k];
    if (hollow <= deepest) continue;
    deepest = hollow;
    valley = profile.lateral(k);
  }
  return valley;
}

}  // namespace

std::optional<NoseSection> CutNose(const SplineSurface& head, const MidPlane& plane, const FacePoints& face, double z) {
  if (!(z >= head.z_min() && z <= head.z_max())) return std::nullopt;
  const Vector3d& root = face.sellion.position;
  const Vector3d& tip = face.pronasale.position;
  const double down = std::clamp((root.z() - z) / std::max(root.z() - tip.z(), 1.0), 0.0, 1.0);
  const double middle = (1.0 - down) * plane.Lateral(root) + down * plane.Lateral(tip);
  const Section section(head, plane, z);
  const Profile profile = Sample(section, middle);
  const std::optional<double> crest = CrestOf(profile, middle);
  if (!crest) return std::nullopt;
  const NoseSection nose{z, section.At(*crest), section.At(ValleyOf(profile, *crest, 1.0)),
                         section.At(ValleyOf(profile, *crest, -1.0))};
  const Vector3d forward = plane.forward();
  const double right = forward.dot(nose.crest - nose.valley_right);
  const double left = forward.dot(nose.crest - nose.valley_left);
  return std::min(right, left) >= kLeastNose ? std::optional(nose) : std::nullopt;
}

std::vector<NoseSection> NoseSections(const SplineSurface& head, const MidPlane& plane, const FacePoints& face,
                                      double step) {
  constexpr double kAboveSellion = 8.0;
  std::vector<NoseSection> sections;
  if (!(step > 0.0)) return sections;
  for (double z = face.sellion.position.z() + kAboveSellion; z >= face.pronasale.position.z(); z -= step) {
    if (const std::optional<NoseSection> section = CutNose(head, plane, face, z)) sections.push_back(*section);
  }
  return sections;
}

std::optional<NoseFlank> FindNoseFlank(const SplineSurface& head, const MidPlane& plane, const NoseSection& nose,
                                       BodySide side, double behind) {
  const Section section(head, plane, nose.z);
  const Vector3d forward = plane.forward();
  const double sign = side == BodySide::kRight ? 1.0 : -1.0;
  const double crest = plane.Lateral(nose.crest);
  const double level = forward.dot(nose.crest) - behind;
  const double far = sign * (plane.Lateral(nose.Valley(side)) - crest);
  // The first place on the way out that lies as far behind.
  double low = 0.0;
  double high = 0.0;
  while (high < far && section.Ahead(crest + sign * high) > level) {
    low = high;
    high = std::min(high + kAcrossStep, far);
  }
  if (!(behind > 0.0) || section.Ahead(crest + sign * high) > level) return std::nullopt;
  for (int step = 0; step < 30; ++step) {
    const double middle = 0.5 * (low + high);
    (section.Ahead(crest + sign * middle) > level ? low : high) = middle;
  }
  NoseFlank flank;
  flank.half_width = 0.5 * (low + high);
  flank.place = {section.Theta(crest + sign * flank.half_width), nose.z};
  flank.point = head.Point(flank.place.theta, nose.z);
  flank.normal = head.Normal(flank.place.theta, nose.z);
  const double outward = sign * plane.right().dot(flank.normal);
  flank.splay = std::atan2(forward.dot(flank.normal), outward);
  flank.frontal_angle = std::atan2(flank.normal.z(), outward);
  flank.sigma = std::numeric_limits<double>::quiet_NaN();
  return flank;
}

std::optional<NoseFlank> FindNoseFlank(const MeasuredSurface& head, const MidPlane& plane, const NoseSection& nose,
                                       BodySide side, double behind) {
  std::optional<NoseFlank> flank = FindNoseFlank(head.surface(), plane, nose, side, behind);
  if (!flank) return flank;
  const Vector3d outwards(std::cos(flank->place.theta), std::sin(flank->place.theta), 0.0);
  const double along = flank->normal.dot(outwards);
  flank->sigma = std::abs(along) * head.RadiusSigma(flank->place.theta, flank->place.z);
  return flank;
}

std::optional<double> NoseBreadth(const SplineSurface& head, const MidPlane& plane, const NoseSection& nose,
                                  double behind) {
  const auto right = FindNoseFlank(head, plane, nose, BodySide::kRight, behind);
  const auto left = FindNoseFlank(head, plane, nose, BodySide::kLeft, behind);
  if (!right || !left) return std::nullopt;
  return right->half_width + left->half_width;
}

}  // namespace annulus
