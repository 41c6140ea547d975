#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "sim/subject.h"

namespace annulus::sim {

/// A round cone on the axis, radius_mm(z) = kFootRadiusMm - kSlope · z: a horizontal beam's range says at which height
/// it was cast. Only for horizontal beams aimed at the axis.
class ConeSubject final : public Subject {
 public:
  static constexpr double kFootRadiusMm = 500.0;
  static constexpr double kSlope = 0.2;

  /// The height at which a ring of radius `ring_radius_mm` reads `range_mm`.
  static double HeightOf(double ring_radius_mm, double range_mm) {
    return (kFootRadiusMm - (ring_radius_mm - range_mm)) / kSlope;
  }

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double, double) const override {
    const double radius = kFootRadiusMm - kSlope * ray.origin.z();
    const double distance = ray.origin.head<2>().norm() - radius;
    return SubjectHit{distance, Eigen::Vector3d(-ray.direction), 1.0};
  }
  [[nodiscard]] double top_mm() const override { return kFootRadiusMm / kSlope; }
  [[nodiscard]] double bottom_mm() const override { return 0.0; }
  [[nodiscard]] std::string name() const override { return "cone"; }
};

}  // namespace annulus::sim
