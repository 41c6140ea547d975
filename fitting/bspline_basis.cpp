#include "fitting/bspline_basis.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {

PeriodicCubicBasis::PeriodicCubicBasis(std::size_t count)
    : count_(count), spacing_(kTwoPi / static_cast<double>(count)) {
  ENSURE(count >= 4, "a periodic cubic spline has at least four intervals");
}

std::size_t PeriodicCubicBasis::Interval(double theta) const {
  return std::min(static_cast<std::size_t>(WrapAngle(theta) / spacing_), count_ - 1);
}

CubicBasis PeriodicCubicBasis::InInterval(std::size_t interval, double theta) const {
  const double t = WrapAngle(theta) / spacing_ - static_cast<double>(interval);
  const double s = 1.0 - t;
  const double h = spacing_;

  CubicBasis basis;
  for (std::size_t k = 0; k < 4; ++k) basis.index[k] = (interval + count_ - 1 + k) % count_;
  basis.value = {s * s * s / 6.0, (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
                 (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0, t * t * t / 6.0};
  basis.first = {-s * s / (2.0 * h), (-4.0 * t + 3.0 * t * t) / (2.0 * h), (4.0 * s - 3.0 * s * s) / (2.0 * h),
                 t * t / (2.0 * h)};
  basis.second = {s / (h * h), (3.0 * t - 2.0) / (h * h), (3.0 * s - 2.0) / (h * h), t / (h * h)};
  return basis;
}

IntervalCubics PeriodicCubicBasis::Cubics() {
  constexpr double kSixth = 1.0 / 6.0;
  return {{{kSixth, -0.5, 0.5, -kSixth},
           {4.0 * kSixth, 0.0, -1.0, 0.5},
           {kSixth, 0.5, 0.5, -0.5},
           {0.0, 0.0, 0.0, kSixth}}};
}

ClampedCubicBasis::ClampedCubicBasis(std::vector<double> breakpoints) : breakpoints_(std::move(breakpoints)) {
  ENSURE(breakpoints_.size() >= 2, "a clamped spline has at least one interval");
  for (std::size_t i = 0; i < breakpoints_.size(); ++i) {
    ENSURE(std::isfinite(breakpoints_[i]), "breakpoints are finite");
    ENSURE(i == 0 || breakpoints_[i - 1] < breakpoints_[i], "breakpoints strictly increase");
  }
  knots_.assign(3, breakpoints_.front());
  knots_.insert(knots_.end(), breakpoints_.begin(), breakpoints_.end());
  knots_.insert(knots_.end(), 3, breakpoints_.back());
}

std::size_t ClampedCubicBasis::Interval(double x) const {
  const auto above = std::upper_bound(breakpoints_.begin() + 1, breakpoints_.end() - 1, x);
  return static_cast<std::size_t>(above - breakpoints_.begin()) - 1;
}

CubicBasis ClampedCubicBasis::InInterval(std::size_t interval, double x) const {
  const std::size_t m = interval + 3;  // the interval [t_m, t_{m+1}) of the full knot vector
  const auto knot = [&](std::size_t i) { return knots_[i]; };

  // Cox–de Boor: rows of order 1 … 4; N[k] of order r is spline m - r + 1 + k.
  std::array<std::array<double, 4>, 5> n{};
  n[1][0] = 1.0;
  for (std::size_t order = 2; order <= 4; ++order) {
    for (std::size_t k = 0; k < order; ++k) {
      const std::size_t i = m + 1 + k - order;  // first knot of the spline
      double value = 0.0;
      if (k > 0) value += (x - knot(i)) / (knot(i + order - 1) - knot(i)) * n[order - 1][k - 1];
      if (k + 1 < order) value += (knot(i + order) - x) / (knot(i + order) - knot(i + 1)) * n[order - 1][k];
      n[order][k] = value;
    }
  }

  // Derivatives: N'_{i,r} = (r-1) (N_{i,r-1}/(t_{i+r-1}-t_i) - N_{i+1,r-1}/(t_{i+r}-t_{i+1})), applied once and twice.
  const auto derivative = [&](std::size_t order, std::size_t k, const std::array<double, 4>& lower) {
    const std::size_t i = m + 1 + k - order;
    double value = 0.0;
    if (k > 0) value += lower[k - 1] / (knot(i + order - 1) - knot(i));
    if (k + 1 < order) value -= lower[k] / (knot(i + order) - knot(i + 1));
    return static_cast<double>(order - 1) * value;
  };
  CubicBasis basis;
  std::array<double, 4> first_of_order_3{};
  for (std::size_t k = 0; k < 3; ++k) first_of_order_3[k] = derivative(3, k, n[2]);
  for (std::size_t k = 0; k < 4; ++k) {
    basis.index[k] = m - 3 + k;
    basis.value[k] = n[4][k];
    basis.first[k] = derivative(4, k, n[3]);
    basis.second[k] = derivative(4, k, first_of_order_3);
  }
  return basis;
}

IntervalCubics ClampedCubicBasis::Cubics(std::size_t interval) const {
  const double h = breakpoints_[interval + 1] - breakpoints_[interval];
  const CubicBasis at_start = InInterval(interval, breakpoints_[interval]);
  const CubicBasis at_end = InInterval(interval, breakpoints_[interval + 1]);
  IntervalCubics cubics;
  for (std::size_t k = 0; k < 4; ++k) {
    cubics[k] = {at_start.value[k], h * at_start.first[k], 0.5 * h * h * at_start.second[k],
                 h * h * (at_end.second[k] - at_start.second[k]) / 6.0};
  }
  return cubics;
}

std::vector<double> UniformBreakpoints(double from, double to, std::size_t count) {
  ENSURE(from < to && count >= 1, "breakpoints span an interval");
  std::vector<double> points(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    points[i] = from + (to - from) * static_cast<double>(i) / static_cast<double>(count);
  }
  points.back() = to;
  return points;
}

}  // namespace annulus
