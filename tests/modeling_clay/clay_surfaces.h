#pragma once

#include <cmath>
#include <vector>

#include "modeling/clay/clay_convert.h"

namespace annulus::test {

/// A segment of constant radius: splines reproduce constants.
inline SurfaceSegment Cylinder(double radius, double height) {
  std::vector<double> breaks;
  for (int i = 0; i <= 10; ++i) breaks.push_back(height * i / 10.0);
  PeriodicCubicBasis theta(36);
  ClampedCubicBasis z(breaks);
  const Eigen::VectorXd coefficients =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(theta.count() * z.count()), radius);
  return {"body", SplineSurface(theta, z, coefficients), KnowledgeMap(1, 1, 0.0, height), {}};
}

/// The same with waves, so that nothing is flat.
inline SurfaceSegment Wavy() {
  SurfaceSegment segment = Cylinder(150.0, 400.0);
  Eigen::VectorXd coefficients = segment.surface.coefficients();
  for (Eigen::Index n = 0; n < coefficients.size(); ++n) {
    coefficients[n] +=
        12.0 * std::sin(0.7 * static_cast<double>(n % 36)) + 9.0 * std::cos(0.9 * static_cast<double>(n / 36));
  }
  segment.surface = SplineSurface(segment.surface.theta_basis(), segment.surface.z_basis(), coefficients);
  return segment;
}

}  // namespace annulus::test
