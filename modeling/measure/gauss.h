#pragma once

#include <array>
#include <span>
#include <vector>

namespace annulus {

/// A node of a quadrature rule.
struct QuadratureNode {
  double x = 0.0;
  double weight = 0.0;
};

/// Gauss–Legendre nodes with 4 points on every interval between successive `breaks` (ascending): exact for polynomials
/// up to degree 7 on each.
[[nodiscard]] std::vector<QuadratureNode> PiecewiseGauss(std::span<const double> breaks);

/// `breaks` clipped to [low, high], with low and high as ends.
[[nodiscard]] std::vector<double> ClipBreaks(std::span<const double> breaks, double low, double high);

}  // namespace annulus
