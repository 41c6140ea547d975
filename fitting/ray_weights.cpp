#include "fitting/ray_weights.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr double kRadial = 0.9995;  // cosine of 1.8 degrees
constexpr double kLeastSquare = 0.25;
constexpr double kMostSquare = 25.0;

/// The ray in the directions of rising radius, theta and z at the sample.
Eigen::Vector3d LocalRay(const SurfaceSample& s) {
  const Eigen::Vector3d ray = s.ray_direction.cast<double>();
  const double c = std::cos(s.theta);
  const double d = std::sin(s.theta);
  return {c * ray.x() + d * ray.y(), -d * ray.x() + c * ray.y(), ray.z()};
}

bool IsOblique(const SurfaceSample& s) { return !s.ray_direction.isZero(0.0F) && -LocalRay(s).x() < kRadial; }

}  // namespace

double ResidualPerRange(const SurfaceSample& sample, const RadiusJet& jet) {
  const Eigen::Vector3d ray = LocalRay(sample);
  return ray.x() - jet.r_theta / std::max(1.0, sample.radius) * ray.y() - jet.r_z * ray.z();
}

bool HasObliqueRays(const FitInput& input) {
  return std::any_of(input.samples.begin(), input.samples.end(), IsOblique);
}

std::vector<float> RayWeights(const FitInput& input, const SplineSurface& surface) {
  if (!HasObliqueRays(input)) return {};
  std::vector<float> weights;
  weights.reserve(input.samples.size());
  for (std::size_t k = 0; k < input.samples.size(); ++k) {
    const SurfaceSample& s = input.samples[k];
    weights.push_back(s.weight);
    if (input.use[k] == 0 || !IsOblique(s)) continue;
    const double change = ResidualPerRange(s, surface.Jet(s.theta, s.z));
    weights.back() /= static_cast<float>(std::clamp(change * change, kLeastSquare, kMostSquare));
  }
  return weights;
}

}  // namespace annulus
