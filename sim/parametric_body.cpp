#include "sim/parametric_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"

namespace annulus::sim {

ParametricBody::ParametricBody(Description description)
    : description_(std::move(description)),
      cos_yaw_(std::cos(description_.placement.yaw_rad)),
      sin_yaw_(std::sin(description_.placement.yaw_rad)) {
  ENSURE(!description_.parts.empty() && description_.parts.front().id == BodyPart::kTorso,
         "the first part is the torso");
  top_ = torso().z_max();
  bottom_ = torso().z_min();
  for (const Part& part : description_.parts) {
    top_ = std::max(top_, part.tube.z_max());
    bottom_ = std::min(bottom_, part.tube.z_min());
  }
}

std::optional<SubjectHit> ParametricBody::Cast(const Ray& ray, double /*time_s*/, double max_distance_mm) const {
  const auto turned = [this](double x, double y, double z) -> Eigen::Vector3d {
    return {cos_yaw_ * x + sin_yaw_ * y, cos_yaw_ * y - sin_yaw_ * x, z};
  };
  const Placement& placement = description_.placement;
  const Ray in_body{turned(ray.origin.x() - placement.x_mm, ray.origin.y() - placement.y_mm, ray.origin.z()),
                    turned(ray.direction.x(), ray.direction.y(), ray.direction.z())};
  std::optional<SubjectHit> nearest;
  double limit = max_distance_mm;
  for (const Part& part : description_.parts) {
    const std::optional<StarTube::Hit> hit = part.tube.Cast(in_body, limit);
    if (!hit) continue;
    limit = hit->distance_mm;
    const Eigen::Vector3d& n = hit->normal;
    nearest = SubjectHit{
        hit->distance_mm, {cos_yaw_ * n.x() - sin_yaw_ * n.y(), sin_yaw_ * n.x() + cos_yaw_ * n.y(), n.z()}, 1.0};
  }
  return nearest;
}

std::optional<SectionTruth> ParametricBody::PartSection(BodyPart part, double z) const {
  for (const Part& candidate : description_.parts) {
    if (candidate.id == part) return candidate.tube.Section(z);
  }
  return std::nullopt;
}

Eigen::Vector3d ParametricBody::StationFromBody(const Eigen::Vector3d& p_in_body) const {
  const Placement& placement = description_.placement;
  return {placement.x_mm + cos_yaw_ * p_in_body.x() - sin_yaw_ * p_in_body.y(),
          placement.y_mm + sin_yaw_ * p_in_body.x() + cos_yaw_ * p_in_body.y(), p_in_body.z()};
}

FaceTruth ParametricBody::face() const {
  const FaceTruth& face = description_.face;
  return {StationFromBody(face.right_eye),    StationFromBody(face.left_eye), StationFromBody(face.right_ear_top),
          StationFromBody(face.left_ear_top), StationFromBody(face.glabella), StationFromBody(face.sellion),
          StationFromBody(face.pronasale)};
}

}  // namespace annulus::sim
