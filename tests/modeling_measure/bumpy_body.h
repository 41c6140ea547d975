#pragma once

#include <cmath>
#include <random>

#include "base/frames.h"
#include "modeling/measure/measured_surface.h"
#include "tests/fitting/synthetic_scan.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus::test {

/// A trunk of 300 mm with bumps and hollows of some 5 mm and an oval section, z from 0.
inline double BumpyRadius(double theta, double z) {
  return 95.0 + 12.0 * std::cos(2.0 * theta) + 5.0 * std::sin(3.0 * theta + 0.02 * z) * std::cos(0.06 * z) +
         4.0 * std::sin(0.05 * z);
}

inline SurfaceModel BumpyBody() { return InterpolatedBody(BumpyRadius, 90, UniformBreakpoints(0.0, 300.0, 75)); }

/// The same knots and knowledge with other coefficients.
inline SurfaceModel WithCoefficients(const SurfaceModel& model, const Eigen::VectorXd& coefficients) {
  const SplineSurface& surface = model.main().surface;
  SurfaceModel other;
  other.segments.push_back(
      {"body", {surface.theta_basis(), surface.z_basis(), coefficients}, model.main().knowledge, {}, {}, {}});
  return other;
}

inline SurfacePlace RandomPlace(std::mt19937_64& random, double z_min, double z_max) {
  const double theta = Uniform(random, 0.0, kTwoPi);
  return {theta, Uniform(random, z_min, z_max)};
}

/// Derivative of a length in one direction of the coefficients, by central differences, and by its own gradient.
struct DirectionalDerivatives {
  double by_differences = 0.0;
  double by_gradient = 0.0;
};
template <class Measure>
DirectionalDerivatives DerivativesOf(const SurfaceModel& model, const Measure& measure, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::VectorXd& c = model.main().surface.coefficients();
  Eigen::VectorXd direction(c.size());
  for (double& value : direction) value = Normal(random);
  constexpr double kStep = 1e-3;  // mm
  const SurfaceModel more = WithCoefficients(model, c + kStep * direction);
  const SurfaceModel less = WithCoefficients(model, c - kStep * direction);
  const auto value = [&](const SurfaceModel& of) { return measure(*MeasuredSurface::FromModel(of)); };
  return {(value(more)->length.value - value(less)->length.value) / (2.0 * kStep),
          value(model)->length.gradient.dot(direction)};
}

}  // namespace annulus::test
