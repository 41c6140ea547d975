#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "sim/subject.h"

namespace annulus::sim {

/// An upright round cylinder on the axis: the simplest thing whose ranges everybody knows (ring radius less its own).
class CylinderSubject final : public Subject {
 public:
  CylinderSubject(double radius_mm, double top_mm) : radius_mm_(radius_mm), top_mm_(top_mm) {}

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double, double max_distance_mm) const override {
    const double a = ray.direction.head<2>().squaredNorm();
    const double b = ray.origin.head<2>().dot(ray.direction.head<2>());
    const double c = ray.origin.head<2>().squaredNorm() - radius_mm_ * radius_mm_;
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) return std::nullopt;
    const double distance = (-b - std::sqrt(discriminant)) / a;
    const Eigen::Vector3d point = ray.origin + distance * ray.direction;
    if (distance < 0.0 || distance > max_distance_mm || point.z() > top_mm_ || point.z() < 0.0) return std::nullopt;
    return SubjectHit{distance, Eigen::Vector3d(point.x(), point.y(), 0.0).normalized(), 1.0};
  }
  [[nodiscard]] double top_mm() const override { return top_mm_; }
  [[nodiscard]] double bottom_mm() const override { return 0.0; }
  [[nodiscard]] std::string name() const override { return "cylinder"; }

 private:
  double radius_mm_;
  double top_mm_;
};

}  // namespace annulus::sim
