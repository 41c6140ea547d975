#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_surface.h"
#include "modeling/glasses/lens_trace.h"

namespace annulus::test {

/// A ray in the lens frame.
struct BundleRay {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< Unit.
};

/// Snell's law by its vector form n·(d × N) preserved.
inline Eigen::Vector3d Bent(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal, double before,
                            double behind) {
  const Eigen::Vector3d tangential = before / behind * (direction - direction.dot(normal) * normal);
  const double along = std::sqrt(1.0 - tangential.squaredNorm());
  return tangential + (direction.dot(normal) > 0.0 ? along : -along) * normal;
}

/// A ray through both surfaces, either way.
inline std::optional<BundleRay> Through(const LensForm& form, const LensSurface& first, const LensSurface& second,
                                        const BundleRay& ray) {
  const auto entry = Meet(first, ray.origin, ray.direction);
  if (!entry) return std::nullopt;
  const Eigen::Vector3d glass = Bent(ray.direction, entry->normal, 1.0, form.index);
  const auto exit = Meet(second, entry->point, glass);
  if (!exit) return std::nullopt;
  return BundleRay{exit->point, Bent(glass, exit->normal, form.index, 1.0)};
}

/// Power straight ahead at the back vertex from a bundle of close rays; no curvature of a surface is used.
inline std::optional<PowerMatrix> BundlePower(const LensForm& form, const LensPose& pose) {
  constexpr double kStep = 0.01;  // mm
  const Eigen::Matrix3d axes = pose.view_from_lens.transpose();
  const Eigen::Vector3d ahead = axes.col(2);
  const auto outside = Through(form, form.back, form.front, {form.back_point - 20.0 * ahead, ahead});
  if (!outside) return std::nullopt;
  Eigen::Matrix2d places;
  Eigen::Matrix2d slopes;
  for (Eigen::Index i = 0; i < 2; ++i) {
    Eigen::Vector3d side = axes.col(i) - axes.col(i).dot(outside->direction) * outside->direction;
    side.normalize();
    Eigen::Vector2d place[2];
    Eigen::Vector2d slope[2];
    for (int sign = 0; sign < 2; ++sign) {
      const Eigen::Vector3d start = outside->origin + (sign == 0 ? kStep : -kStep) * side + 5.0 * outside->direction;
      const auto ray = Through(form, form.front, form.back, {start, -outside->direction});
      if (!ray) return std::nullopt;
      const Eigen::Vector3d from_vertex = axes.transpose() * (ray->origin - form.back_point);
      const Eigen::Vector3d direction = axes.transpose() * ray->direction;
      slope[sign] = direction.head<2>() / -direction.z();
      place[sign] = from_vertex.head<2>() + from_vertex.z() * slope[sign];
    }
    places.col(i) = place[0] - place[1];
    slopes.col(i) = slope[0] - slope[1];
  }
  return PowerMatrix(-1000.0 * slopes * places.inverse());
}

}  // namespace annulus::test
