#include "sim/acting_subject.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"
#include "sim/round_bar.h"

namespace annulus::sim {

WalkingSubject::WalkingSubject(std::unique_ptr<const Subject> rest, std::optional<StepAside> step,
                               std::optional<double> leave_s)
    : rest_(std::move(rest)), step_(step), leave_s_(leave_s) {
  ENSURE(rest_ != nullptr, "somebody walks");
  if (step_) ENSURE(step_->lasts_s > 0.0, "a step takes time");
}

std::optional<SubjectHit> WalkingSubject::Cast(const Ray& ray, double time_s, double max_distance_mm) const {
  if (leave_s_ && time_s >= *leave_s_) return std::nullopt;
  if (!step_ || time_s <= step_->at_s) return rest_->Cast(ray, time_s, max_distance_mm);
  // A smooth start and end of the step: a raised cosine.
  const double share = 0.5 - 0.5 * std::cos(kPi * std::min(1.0, (time_s - step_->at_s) / step_->lasts_s));
  const Eigen::AngleAxisd turn(share * step_->yaw_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d moved = share * Eigen::Vector3d(step_->x_mm, step_->y_mm, 0.0);
  std::optional<SubjectHit> hit =
      rest_->Cast({turn.inverse() * (ray.origin - moved), turn.inverse() * ray.direction}, time_s, max_distance_mm);
  if (hit) hit->normal = turn * hit->normal;
  return hit;
}

ArmRaisingSubject::ArmRaisingSubject(std::unique_ptr<const Subject> before, std::unique_ptr<const Subject> without_arm,
                                     const HeldOutArm& arm)
    : before_(std::move(before)), without_arm_(std::move(without_arm)), arm_(arm) {
  ENSURE(before_ != nullptr && without_arm_ != nullptr, "somebody raises an arm");
  ENSURE(arm_.radius_mm > 0.0, "an arm has a radius");
}

std::optional<SubjectHit> ArmRaisingSubject::Cast(const Ray& ray, double time_s, double max_distance_mm) const {
  if (time_s < arm_.at_s) return before_->Cast(ray, time_s, max_distance_mm);
  std::optional<SubjectHit> nearest = without_arm_->Cast(ray, time_s, max_distance_mm);
  for (const auto& [from, to] : {std::pair{arm_.shoulder, arm_.elbow}, std::pair{arm_.elbow, arm_.hand}}) {
    const std::optional<SubjectHit> hit = CastRoundBar(ray, from, to, arm_.radius_mm);
    if (hit && hit->distance_mm <= max_distance_mm) nearest = Nearer(nearest, hit);
  }
  return nearest;
}

}  // namespace annulus::sim
