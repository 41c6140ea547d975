#include "modeling/measure/gauss.h"

#include <cmath>

namespace annulus {

std::vector<QuadratureNode> PiecewiseGauss(std::span<const double> breaks) {
  // Roots of the Legendre polynomial P4: x² = 3/7 ∓ (2/7)·sqrt(6/5), weights (18 ± sqrt 30)/36.
  const double inner = std::sqrt(3.0 / 7.0 - 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
  const double outer = std::sqrt(3.0 / 7.0 + 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
  const double inner_weight = (18.0 + std::sqrt(30.0)) / 36.0;
  const double outer_weight = (18.0 - std::sqrt(30.0)) / 36.0;
  const std::array<QuadratureNode, 4> unit{
      {{-outer, outer_weight}, {-inner, inner_weight}, {inner, inner_weight}, {outer, outer_weight}}};
  std::vector<QuadratureNode> nodes;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double half = 0.5 * (breaks[k + 1] - breaks[k]);
    const double middle = 0.5 * (breaks[k + 1] + breaks[k]);
    for (const QuadratureNode& node : unit) nodes.push_back({middle + half * node.x, half * node.weight});
  }
  return nodes;
}

std::vector<double> ClipBreaks(std::span<const double> breaks, double low, double high) {
  std::vector<double> clipped{low};
  for (const double x : breaks) {
    if (x > low && x < high) clipped.push_back(x);
  }
  clipped.push_back(high);
  return clipped;
}

}  // namespace annulus
