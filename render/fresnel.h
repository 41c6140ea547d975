#pragma once

#include <Eigen/Core>
#include <optional>

namespace annulus {

/// Share of unpolarised light that a smooth boundary of two dielectrics reflects: Fresnel's equations, the mean of both
/// polarisations. `cosine` (0 … 1) of the angle of incidence, `ratio` = index before / index behind, > 0. 1 at total
/// reflection. What is not reflected is passed on.
[[nodiscard]] double FresnelReflectance(double cosine, double ratio);

/// Cosine of the refracted ray's angle by Snell's law; none at total reflection. Arguments as FresnelReflectance.
[[nodiscard]] std::optional<double> RefractedCosine(double cosine, double ratio);

/// Snell's law: where a ray along the unit `direction` goes on behind a surface of unit normal `normal` on either side,
/// `ratio` = index before / index behind. Unit. None at total reflection.
[[nodiscard]] std::optional<Eigen::Vector3d> Refract(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                                     double ratio);

/// The mirrored direction; `normal` unit, on either side.
[[nodiscard]] inline Eigen::Vector3d Reflect(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal) {
  return direction - 2.0 * direction.dot(normal) * normal;
}

}  // namespace annulus
