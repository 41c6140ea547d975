#include "render/fresnel.h"

#include <cmath>

namespace annulus {

std::optional<double> RefractedCosine(double cosine, double ratio) {
  const double inside = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
  if (!(inside >= 0.0)) return std::nullopt;
  return std::sqrt(inside);
}

double FresnelReflectance(double cosine, double ratio) {
  const auto refracted = RefractedCosine(cosine, ratio);
  if (!refracted) return 1.0;
  const double across = ratio * cosine + *refracted;
  const double along = cosine + ratio * *refracted;
  if (!(across > 0.0 && along > 0.0)) return 1.0;
  const double s = (ratio * cosine - *refracted) / across;
  const double p = (cosine - ratio * *refracted) / along;
  return 0.5 * (s * s + p * p);
}

std::optional<Eigen::Vector3d> Refract(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal, double ratio) {
  const double cosine = direction.dot(normal);
  const auto refracted = RefractedCosine(std::abs(cosine), ratio);
  if (!refracted) return std::nullopt;
  return (ratio * direction + (std::copysign(*refracted, cosine) - ratio * cosine) * normal).normalized();
}

}  // namespace annulus
