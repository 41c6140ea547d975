#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/subject.h"

namespace annulus::sim {

/// The nearer of two hits; none only if both are.
[[nodiscard]] std::optional<SubjectHit> Nearer(const std::optional<SubjectHit>& a, const std::optional<SubjectHit>& b);

/// Where a ray from outside first meets all points within `radius_mm` > 0 of the line from `from` to `to`.
[[nodiscard]] std::optional<SubjectHit> CastRoundBar(const Ray& ray, const Eigen::Vector3d& from,
                                                     const Eigen::Vector3d& to, double radius_mm);

}  // namespace annulus::sim
