#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace annulus {

/// The four cubic B-splines (order k = 4) that are not zero at one parameter, with derivatives.
struct CubicBasis {
  std::array<std::size_t, 4> index{};  ///< Coefficient indices, in order of the splines' support.
  std::array<double, 4> value{};       ///< N_i(x).
  std::array<double, 4> first{};       ///< N_i'(x).
  std::array<double, 4> second{};      ///< N_i''(x).
};

/// The four splines of one interval as polynomials of t = 0 … 1 along it: N_k = Σ_p c[k][p] t^p.
using IntervalCubics = std::array<std::array<double, 4>, 4>;

/// Their values.
[[nodiscard]] inline std::array<double, 4> ValuesAt(const IntervalCubics& c, double t) {
  std::array<double, 4> values;
  for (std::size_t k = 0; k < 4; ++k) values[k] = ((c[k][3] * t + c[k][2]) * t + c[k][1]) * t + c[k][0];
  return values;
}

/// Cubic B-splines on a circle with `count` equal intervals over [0, 2 pi) (paper 001, eqs. 2.8–2.10: uniform,
/// closed in u). Knot i lies at i·2 pi/count; spline i is centred on knot i, so that at knot i the values are
/// 1/6, 2/3, 1/6 for splines i-1, i, i+1.
class PeriodicCubicBasis {
 public:
  /// Requires count >= 4.
  explicit PeriodicCubicBasis(std::size_t count);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// Distance of knots, rad.
  [[nodiscard]] double spacing() const { return spacing_; }
  /// The interval that holds any finite theta, rad (wrapped): 0 … count - 1.
  [[nodiscard]] std::size_t Interval(double theta) const;
  /// The basis at any finite theta, rad (wrapped).
  [[nodiscard]] CubicBasis At(double theta) const { return InInterval(Interval(theta), theta); }
  /// The same with the polynomials of a given interval, which theta should lie in or at the edge of.
  [[nodiscard]] CubicBasis InInterval(std::size_t interval, double theta) const;
  /// The polynomials, the same in every interval.
  [[nodiscard]] static IntervalCubics Cubics();

 private:
  std::size_t count_;
  double spacing_;
};

/// Cubic B-splines on [first knot, last knot] with end knots of multiplicity four ("clamped"), any interior knots.
/// Evaluated by the Cox–de Boor recurrence.
class ClampedCubicBasis {
 public:
  /// `breakpoints`: at least two, strictly increasing, finite (ends included once). Requires that.
  explicit ClampedCubicBasis(std::vector<double> breakpoints);

  /// Number of coefficients = breakpoints + 2.
  [[nodiscard]] std::size_t count() const { return breakpoints_.size() + 2; }
  [[nodiscard]] const std::vector<double>& breakpoints() const { return breakpoints_; }
  [[nodiscard]] double min() const { return breakpoints_.front(); }
  [[nodiscard]] double max() const { return breakpoints_.back(); }
  /// The interval that holds x, 0 … breakpoints - 2; the first or last for x outside.
  [[nodiscard]] std::size_t Interval(double x) const;
  /// The basis at x; outside [min, max] the end polynomial is continued.
  [[nodiscard]] CubicBasis At(double x) const { return InInterval(Interval(x), x); }
  /// The same with the polynomials of a given interval.
  [[nodiscard]] CubicBasis InInterval(std::size_t interval, double x) const;
  /// The polynomials of an interval.
  [[nodiscard]] IntervalCubics Cubics(std::size_t interval) const;

 private:
  std::vector<double> breakpoints_;
  std::vector<double> knots_;  ///< With repeated ends.
};

/// `count` + 1 equal breakpoints from `from` to `to` (from < to, count >= 1).
[[nodiscard]] std::vector<double> UniformBreakpoints(double from, double to, std::size_t count);

}  // namespace annulus
