#include "sim/clothed_subject.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "sim/space_noise.h"

namespace annulus::sim {

ClothedSubject::ClothedSubject(std::unique_ptr<const Subject> bare, std::optional<Cap> cap,
                               std::optional<LooseClothing> clothing)
    : bare_(std::move(bare)), cap_(cap), clothing_(clothing) {
  ENSURE(bare_ != nullptr, "somebody wears the clothes");
  if (cap_) ENSURE(cap_->thickness_mm > 0.0 && cap_->visor_width_mm > 0.0 && cap_->board_mm > 0.0, "a cap has sizes");
  if (clothing_) {
    ENSURE(clothing_->high_mm > clothing_->low_mm && clothing_->fold_width_mm > 0.0 && clothing_->flutter_s > 0.0,
           "clothing has sizes");
  }
}

double ClothedSubject::ClothAt(const Eigen::Vector3d& p, double time_s) const {
  const LooseClothing& cloth = *clothing_;
  if (p.z() < cloth.low_mm || p.z() > cloth.high_mm) return 0.0;
  // At the neckline the cloth lies on the skin, the hem hangs free.
  constexpr double kNeckline = 60.0;
  const double held = std::min(1.0, (cloth.high_mm - p.z()) / kNeckline);
  const double width = cloth.fold_width_mm;
  constexpr double kLength = 3.0;
  const double fold = SpaceNoise({p.x() / width, p.y() / width, p.z() / (kLength * width) + time_s / cloth.flutter_s});
  return held * std::max(0.0, cloth.ease_mm + cloth.fold_mm * (fold - 0.5));
}

std::optional<SubjectHit> ClothedSubject::CastVisor(const Ray& ray, double max_distance_mm) const {
  // The rim of the board is half an ellipse about the middle of the forehead; a level ray meets its edge.
  const Cap& cap = *cap_;
  const Eigen::Array2d half(0.5 * cap.visor_width_mm, cap.visor_mm);
  const Eigen::Vector2d centre(cap.axis_x_mm, cap.axis_y_mm + cap.forehead_mm);
  const Eigen::Vector2d o = (ray.origin.head<2>() - centre).array() / half;
  const Eigen::Vector2d d = ray.direction.head<2>().array() / half;
  const double a = d.squaredNorm();
  if (a < 1e-18) return std::nullopt;
  const double half_b = o.dot(d);
  const double discriminant = half_b * half_b - a * (o.squaredNorm() - 1.0);
  if (discriminant < 0.0) return std::nullopt;
  const double distance = (-half_b - std::sqrt(discriminant)) / a;
  if (distance < 0.0 || distance > max_distance_mm) return std::nullopt;
  const Eigen::Vector3d p = ray.origin + distance * ray.direction;
  if (p.y() < centre.y() || p.z() < cap.rim_mm || p.z() > cap.rim_mm + cap.board_mm) return std::nullopt;
  const Eigen::Vector2d outward = ((p.head<2>() - centre).array() / half.square()).matrix().normalized();
  return SubjectHit{distance, {outward.x(), outward.y(), 0.0}, 0.7};
}

std::optional<SubjectHit> ClothedSubject::Cast(const Ray& ray, double time_s, double max_distance_mm) const {
  // What is worn may be within reach though the skin below it is not.
  const double deepest =
      std::max(cap_ ? cap_->thickness_mm : 0.0, clothing_ ? clothing_->ease_mm + clothing_->fold_mm : 0.0);
  std::optional<SubjectHit> hit = bare_->Cast(ray, time_s, max_distance_mm + deepest);
  if (hit) {
    const Eigen::Vector3d p = ray.origin + hit->distance_mm * ray.direction;
    if (clothing_) hit->distance_mm = std::max(0.0, hit->distance_mm - ClothAt(p, time_s));
    if (cap_ && p.z() >= cap_->rim_mm) {
      hit->distance_mm = std::max(0.0, hit->distance_mm - cap_->thickness_mm);
      hit->reflectance *= 0.7;
    }
  }
  if (hit && hit->distance_mm > max_distance_mm) hit.reset();
  if (!cap_ || cap_->visor_mm <= 0.0) return hit;
  const std::optional<SubjectHit> visor = CastVisor(ray, hit ? hit->distance_mm : max_distance_mm);
  return visor ? visor : hit;
}

}  // namespace annulus::sim
