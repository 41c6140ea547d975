#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

#include "fitting/surface_model.h"
#include "modeling/flatten/pattern.h"

namespace annulus::test {

/// A segment whose coefficients are a function's values at the splines' middles (Greville's abscissae): exact where
/// the function is constant around and linear in z, a smooth body near to it elsewhere.
inline SurfaceSegment BodyOf(double z_low, double z_high, const std::function<double(double, double)>& radius) {
  const PeriodicCubicBasis theta(60);
  const ClampedCubicBasis z(UniformBreakpoints(z_low, z_high, 30));
  std::vector<double> knots(3, z_low);
  knots.insert(knots.end(), z.breakpoints().begin(), z.breakpoints().end());
  knots.insert(knots.end(), 3, z_high);
  Eigen::VectorXd c(static_cast<Eigen::Index>(theta.count() * z.count()));
  for (std::size_t j = 0; j < z.count(); ++j) {
    const double middle = (knots[j + 1] + knots[j + 2] + knots[j + 3]) / 3.0;
    for (std::size_t i = 0; i < theta.count(); ++i) {
      c[static_cast<Eigen::Index>(j * theta.count() + i)] = radius(theta.spacing() * static_cast<double>(i), middle);
    }
  }
  return {"body", SplineSurface(theta, z, c), KnowledgeMap(1, 1, z_low, z_high), {}};
}

/// A trunk from z = 900 to 1400 mm: an oval with a waist at 1000 mm, and two breasts of `bust` mm about 1200 mm.
inline SurfaceSegment Trunk(double size, double bust) {
  return BodyOf(900.0, 1400.0, [=](double theta, double z) {
    const auto bump = [](double x, double width) { return std::exp(-x * x / (width * width)); };
    double r =
        size * (1.0 - 0.12 * std::cos(2.0 * (theta - std::numbers::pi / 2.0))) * (1.0 - 0.18 * bump(z - 1000.0, 120.0));
    for (const double side : {-0.45, 0.45}) {
      const double turn = std::remainder(theta - std::numbers::pi / 2.0 - side, 2.0 * std::numbers::pi);
      r += bust * bump(turn, 0.35) * bump(z - 1200.0, 60.0);
    }
    return r;
  });
}

/// Levels of the trunk, so that patterns that name landmarks lie on it.
inline PatternBody OnTrunk(const SurfaceSegment& segment) {
  const double no_angle = std::nan("");
  return {segment, {{"level.waist", {no_angle, 1000.0}}, {"level.axilla", {no_angle, 1300.0}}}};
}

}  // namespace annulus::test
