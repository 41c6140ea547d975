#include "modeling/landmarks/face_relief.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace annulus {
namespace {

/// Pupillary distance of a face of scale 1, mm.
constexpr double kUsualPupils = 63.0;
constexpr double kStep = 0.5;        // mm, of searches along the height
constexpr double kLipChord = 3.0;    // mm, half the chord over which lips and their crease show
constexpr double kBrowChord = 6.0;   // mm
constexpr double kLeastBulge = 0.2;  // mm, of a lip
constexpr double kLipReach = 10.0;   // mm from the crease within which a lip bulges most

/// The scale of a face; 0.8 … 1.25.
double ScaleOf(const FacePoints& face) {
  return std::clamp((face.eye_right.position - face.eye_left.position).norm() / kUsualPupils, 0.8, 1.25);
}

/// Hollow of the mid profile, the mean over the middle of the mouth.
double MiddleHollow(const FaceRelief& relief, double z) {
  constexpr std::array<double, 5> kAcross = {-6.0, -3.0, 0.0, 3.0, 6.0};
  double sum = 0.0;
  for (const double lateral : kAcross) sum += relief.Hollow(lateral, z, kLipChord);
  return sum / static_cast<double>(kAcross.size());
}

/// Samples of the hollow from top to bottom.
struct HollowProfile {
  double top = 0.0;
  std::vector<double> hollow;

  [[nodiscard]] double z(std::size_t k) const { return top - kStep * static_cast<double>(k); }
  /// Index of the strongest bulge among those from `from` to `to` (inclusive, held within the profile).
  [[nodiscard]] std::size_t Bulge(std::ptrdiff_t from, std::ptrdiff_t to) const {
    const auto last = static_cast<std::ptrdiff_t>(hollow.size()) - 1;
    const auto begin = hollow.begin() + std::clamp<std::ptrdiff_t>(from, 0, last);
    const auto end = hollow.begin() + std::clamp<std::ptrdiff_t>(to, 0, last) + 1;
    return static_cast<std::size_t>(std::min_element(begin, end) - hollow.begin());
  }
};

/// Where crease and lips were found, indices into the profile.
struct Crease {
  std::size_t upper;
  std::size_t middle;
  std::size_t lower;
};

std::optional<Crease> FindCrease(const HollowProfile& profile) {
  constexpr auto kReach = static_cast<std::ptrdiff_t>(kLipReach / kStep);
  constexpr auto kApart = static_cast<std::ptrdiff_t>(2.0 / kStep);
  std::optional<Crease> best;
  double best_score = 0.0;
  for (std::size_t k = 1; k + 1 < profile.hollow.size(); ++k) {
    const double depth = profile.hollow[k];
    if (depth <= 0.0 || depth < profile.hollow[k - 1] || depth < profile.hollow[k + 1]) continue;
    const auto at = static_cast<std::ptrdiff_t>(k);
    const std::size_t upper = profile.Bulge(at - kReach, at - kApart);
    const std::size_t lower = profile.Bulge(at + kApart, at + kReach);
    const double bulge = -std::max(profile.hollow[upper], profile.hollow[lower]);
    if (bulge < kLeastBulge || depth + bulge <= best_score) continue;
    best_score = depth + bulge;
    best = Crease{upper, k, lower};
  }
  return best;
}

/// The corner of the mouth on one side: where the crease, followed outwards, has become a quarter as deep.
void FindCorner(const FaceRelief& relief, Mouth& mouth, std::size_t side, double scale) {
  const double sign = side == 0 ? 1.0 : -1.0;
  const double deep = MiddleHollow(relief, mouth.stomion);
  double z = mouth.stomion;
  double lateral = 6.0;
  for (; lateral < 30.0 * scale; lateral += 1.0) {
    double best = -1e9;
    double best_z = z;
    for (double near = z - 1.0; near <= z + 1.0; near += kStep) {
      const double hollow = relief.Hollow(sign * lateral, near, kLipChord);
      if (hollow <= best) continue;
      best = hollow;
      best_z = near;
    }
    if (best < 0.25 * deep) break;
    z = best_z;
  }
  mouth.half_breadth[side] = std::clamp(lateral, 19.0 * scale, 29.0 * scale);
  const double share = mouth.half_breadth[side] / std::max(lateral, 1.0);
  mouth.corner_rise[side] = std::clamp((z - mouth.stomion) * share, -5.0 * scale, 5.0 * scale);
}

}  // namespace

Eigen::Vector3d FaceRelief::PointAt(double lateral, double z) const {
  constexpr double kSector = 1.2;
  constexpr int kHalvings = 34;
  const double height = std::clamp(z, head_.z_min(), head_.z_max());
  double right = plane_.yaw - kSector;
  double left = plane_.yaw + kSector;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (right + left);
    (plane_.Lateral(head_.Point(middle, height)) > lateral ? right : left) = middle;
  }
  return head_.Point(0.5 * (right + left), height);
}

double FaceRelief::Forward(double lateral, double z) const { return PointAt(lateral, z).dot(plane_.forward()); }

double FaceRelief::Hollow(double lateral, double z, double half) const {
  return 0.5 * (Forward(lateral, z + half) + Forward(lateral, z - half)) - Forward(lateral, z);
}

Mouth FindMouth(const FaceRelief& relief, const FacePoints& face) {
  const double scale = ScaleOf(face);
  const double tip = face.pronasale.position.z();
  const double nose = std::clamp(face.sellion.position.z() - tip, 30.0, 50.0);
  HollowProfile profile{tip - 0.5 * nose, {}};
  for (double z = profile.top; z > tip - 1.45 * nose; z -= kStep) profile.hollow.push_back(MiddleHollow(relief, z));
  const std::optional<Crease> crease = FindCrease(profile);
  Mouth mouth;
  if (!crease) {
    mouth.stomion = tip - 0.9 * nose;
    mouth.half_breadth = {24.5 * scale, 24.5 * scale};
    mouth.upper_height = 6.5 * scale;
    mouth.lower_height = 8.5 * scale;
    return mouth;
  }
  mouth.source = LandmarkSource::kDetected;
  mouth.stomion = profile.z(crease->middle);
  mouth.upper_height = std::clamp(profile.z(crease->upper) - mouth.stomion + 2.2 * scale, 5.0 * scale, 8.5 * scale);
  mouth.lower_height = std::clamp(mouth.stomion - profile.z(crease->lower) + 2.8 * scale, 6.0 * scale, 10.5 * scale);
  for (std::size_t side = 0; side < 2; ++side) FindCorner(relief, mouth, side, scale);
  // A crease may fade early on one side only: mouths are not so uneven.
  constexpr double kEven = 0.9;
  auto& [right, left] = mouth.half_breadth;
  right = std::max(right, kEven * left);
  left = std::max(left, kEven * right);
  return mouth;
}

double FindBrowHeight(const FaceRelief& relief, const FacePoints& face, double eye_lateral, double eye_z) {
  const double scale = ScaleOf(face);
  constexpr std::array<double, 5> kAcross = {-8.0, -4.0, 0.0, 4.0, 8.0};
  double best = -0.15;  // mm; a flatter forehead has no ridge
  double ridge = 15.5 * scale;
  for (double above = 9.0 * scale; above <= 27.0 * scale; above += kStep) {
    double sum = 0.0;
    for (const double across : kAcross) sum += relief.Hollow(eye_lateral + across, eye_z + above, kBrowChord);
    const double hollow = sum / static_cast<double>(kAcross.size());
    if (hollow >= best) continue;
    best = hollow;
    ridge = above;
  }
  // The hair grows on the ridge and a little above.
  return eye_z + std::clamp(ridge + 1.0 * scale, 13.5 * scale, 22.0 * scale);
}

}  // namespace annulus
