#include "sim/dressed_subject.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"
#include "sim/round_bar.h"
#include "sim/space_noise.h"

namespace annulus::sim {
DressedSubject::DressedSubject(std::unique_ptr<const Subject> bare, Dress dress)
    : bare_(std::move(bare)), dress_(std::move(dress)) {
  ENSURE(bare_ != nullptr, "somebody wears the dress");
  if (dress_.hair) ENSURE(dress_.hair->thickness_mm > 0.0 && dress_.hair->strand_mm > 0.0, "hair has a thickness");
  if (dress_.spectacles) BuildSpectacles();
}

double DressedSubject::top_mm() const { return bare_->top_mm() + (dress_.hair ? dress_.hair->thickness_mm : 0.0); }

void DressedSubject::BuildSpectacles() {
  const WornSpectacles& worn = *dress_.spectacles;
  ENSURE(worn.wire_radius_mm > 0.0, "wire has a radius");
  const FaceTruth& face = worn.face;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d across = (face.right_eye - face.left_eye).normalized();
  const Eigen::Vector3d forward = up.cross(across);
  // In front of the nasal root by the wire and some air, a little below the pupils.
  const double ahead = std::max(12.0, (face.sellion - face.right_eye).dot(forward) + worn.wire_radius_mm + 2.0);
  constexpr int kPieces = 24;
  constexpr double kBelowPupil = 3.0;
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d& eye = side > 0.0 ? face.right_eye : face.left_eye;
    const Eigen::Vector3d centre = eye + ahead * forward - kBelowPupil * up;
    const Lens lens{centre, across * worn.rim_half_width_mm, up * worn.rim_half_height_mm, forward};
    lenses_.push_back(lens);
    const auto rim = [&lens](int piece) -> Eigen::Vector3d {
      const double angle = kTwoPi * piece / kPieces;
      return lens.centre + std::cos(angle) * lens.across + std::sin(angle) * lens.up;
    };
    for (int piece = 0; piece < kPieces; ++piece) wire_.push_back({rim(piece), rim(piece + 1)});
    const Eigen::Vector3d& ear = side > 0.0 ? face.right_ear_top : face.left_ear_top;
    const Eigen::Vector3d outer = centre + side * lens.across + 0.4 * lens.up;
    const Eigen::Vector3d hinge = outer + side * 14.0 * across - 4.0 * forward;
    wire_.push_back({outer, hinge});
    wire_.push_back({hinge, ear + worn.wire_radius_mm * up});
  }
  wire_.push_back({lenses_[0].centre - lenses_[0].across, lenses_[1].centre + lenses_[1].across});
  for (const Capsule& capsule : wire_)
    wire_centre_ += (capsule.from + capsule.to) / (2.0 * static_cast<double>(wire_.size()));
  for (const Capsule& capsule : wire_) {
    wire_reach_ = std::max({wire_reach_, (capsule.from - wire_centre_).norm() + worn.wire_radius_mm,
                            (capsule.to - wire_centre_).norm() + worn.wire_radius_mm});
  }
}

std::optional<SubjectHit> DressedSubject::CastWire(const Ray& ray, double max_distance_mm) const {
  const Eigen::Vector3d to_centre = wire_centre_ - ray.origin;
  const double along = to_centre.dot(ray.direction);
  if ((to_centre - along * ray.direction).squaredNorm() > wire_reach_ * wire_reach_) return std::nullopt;
  const double radius = dress_.spectacles->wire_radius_mm;
  std::optional<SubjectHit> nearest;
  for (const Capsule& capsule : wire_) {
    nearest = Nearer(nearest, CastRoundBar(ray, capsule.from, capsule.to, radius));
  }
  if (!nearest || nearest->distance_mm > max_distance_mm) return std::nullopt;
  nearest->reflectance = dress_.spectacles->frame_reflectance;
  return nearest;
}

bool DressedSubject::PassesLens(const Ray& ray, double distance_mm) const {
  return std::any_of(lenses_.begin(), lenses_.end(), [&](const Lens& lens) {
    const double slope = ray.direction.dot(lens.forward);
    if (slope == 0.0) return false;
    const double distance = (lens.centre - ray.origin).dot(lens.forward) / slope;
    if (distance < 0.0 || distance > distance_mm) return false;
    const Eigen::Vector3d p = ray.origin + distance * ray.direction - lens.centre;
    const double u = p.dot(lens.across) / lens.across.squaredNorm();
    const double v = p.dot(lens.up) / lens.up.squaredNorm();
    return u * u + v * v < 1.0;
  });
}

SubjectHit DressedSubject::WithHair(SubjectHit hit, const Eigen::Vector3d& p) const {
  const Hair& hair = *dress_.hair;
  const double x = p.x() - hair.axis_x_mm;
  const double y = p.y() - hair.axis_y_mm;
  const double rho = std::hypot(x, y);
  const double front = rho > 0.0 ? 0.5 + 0.5 * y / rho : 0.5;  // 1 at the front, 0 at the back
  if (p.z() < hair.back_edge_mm + front * (hair.front_edge_mm - hair.back_edge_mm)) return hit;
  hit.distance_mm = std::max(0.0, hit.distance_mm - hair.thickness_mm * SpaceNoise(p / hair.strand_mm));
  hit.reflectance *= hair.reflectance;
  return hit;
}

std::optional<SubjectHit> DressedSubject::Cast(const Ray& ray, double time_s, double max_distance_mm) const {
  std::optional<SubjectHit> hit = bare_->Cast(ray, time_s, max_distance_mm);
  if (hit) {
    const Eigen::Vector3d p = ray.origin + hit->distance_mm * ray.direction;
    for (const DarkPatch& patch : dress_.dark_patches) {
      if ((p - patch.centre).norm() < patch.radius_mm) hit->reflectance *= patch.reflectance;
    }
    if (dress_.hair) hit = WithHair(*hit, p);
  }
  if (!dress_.spectacles) return hit;
  if (hit && PassesLens(ray, hit->distance_mm)) {
    hit->reflectance *= dress_.spectacles->lens_transmission * dress_.spectacles->lens_transmission;
  }
  return Nearer(hit, CastWire(ray, hit ? hit->distance_mm : max_distance_mm));
}

}  // namespace annulus::sim
