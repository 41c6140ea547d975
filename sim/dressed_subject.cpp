#include "sim/dressed_subject.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus::sim {
namespace {

// [0, 1) from a cell of space; the finaliser of splitmix64 (Steele, Lea and Flood, 2014).
double HashCell(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL +
                    static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL +
                    static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
  h = (h ^ (h >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27U)) * 0x94D049BB133111EBULL;
  return static_cast<double>((h ^ (h >> 31U)) >> 11U) * 0x1p-53;
}

// Value noise in [0, 1): hashed at whole places, trilinear between.
double Noise(const Eigen::Vector3d& p) {
  const Eigen::Vector3d cell = p.array().floor();
  const Eigen::Vector3d share = p - cell;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i step(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] == 1 ? share[axis] : 1.0 - share[axis];
    sum += weight * HashCell(static_cast<std::int64_t>(cell.x()) + step.x(),
                             static_cast<std::int64_t>(cell.y()) + step.y(),
                             static_cast<std::int64_t>(cell.z()) + step.z());
  }
  return sum;
}

// Nearest entry of the ray into the ball, if the origin is outside.
std::optional<SubjectHit> CastBall(const Ray& ray, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d to_centre = centre - ray.origin;
  const double along = to_centre.dot(ray.direction);
  const double discriminant = radius * radius - (to_centre - along * ray.direction).squaredNorm();
  if (discriminant < 0.0) return std::nullopt;
  const double distance = along - std::sqrt(discriminant);
  if (distance < 0.0) return std::nullopt;
  return SubjectHit{distance, (ray.origin + distance * ray.direction - centre) / radius, 1.0};
}

// Nearest entry into the mantle of a cylinder between its two end planes.
std::optional<SubjectHit> CastMantle(const Ray& ray, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                     double radius) {
  const Eigen::Vector3d axis = (to - from).normalized();
  const Eigen::Vector3d d = ray.direction - axis * ray.direction.dot(axis);
  const Eigen::Vector3d o = (ray.origin - from) - axis * (ray.origin - from).dot(axis);
  const double a = d.squaredNorm();
  if (a < 1e-18) return std::nullopt;  // along the axis: the end balls are met instead
  const double half_b = d.dot(o);
  const double discriminant = half_b * half_b - a * (o.squaredNorm() - radius * radius);
  if (discriminant < 0.0) return std::nullopt;
  const double distance = (-half_b - std::sqrt(discriminant)) / a;
  const Eigen::Vector3d p = ray.origin + distance * ray.direction;
  const double height = (p - from).dot(axis);
  if (distance < 0.0 || height < 0.0 || height > (to - from).norm()) return std::nullopt;
  return SubjectHit{distance, (p - from - axis * height) / radius, 1.0};
}

std::optional<SubjectHit> Nearer(const std::optional<SubjectHit>& a, const std::optional<SubjectHit>& b) {
  if (!a) return b;
  if (!b) return a;
  return a->distance_mm <= b->distance_mm ? a : b;
}

}  // namespace

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
    nearest = Nearer(nearest, CastMantle(ray, capsule.from, capsule.to, radius));
    nearest = Nearer(nearest, CastBall(ray, capsule.from, radius));
    nearest = Nearer(nearest, CastBall(ray, capsule.to, radius));
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
  hit.distance_mm = std::max(0.0, hit.distance_mm - hair.thickness_mm * Noise(p / hair.strand_mm));
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
