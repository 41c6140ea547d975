#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"

namespace annulus {

/// What was measured along one line on the body: a cross-section (x = theta, rad, closed) or a longitudinal section
/// (x = z, mm, open). A hole is a sample of weight 0, whatever its value.
struct CurveSamples {
  std::vector<double> x;       ///< Strictly increasing; within one period if closed.
  std::vector<double> value;   ///< Radius, mm.
  std::vector<double> weight;  ///< 0 … 1; 1 is an ordinary return.
  double period = 0.0;         ///< 2 pi for a closed curve, 0 for an open one.

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] bool closed() const { return period > 0.0; }
};

/// The cubic B-splines N_{i,4} of paper 001, eq. 2.3 (closed) and eq. 2.12 (open, end knots fourfold) over knots at
/// unequal distances. Immutable value.
class KnotSplineBasis {
 public:
  /// Strictly increasing knots; `period` 0 for an open curve. Requires at least 4 knots if closed (all within one
  /// period), 2 if open.
  KnotSplineBasis(std::vector<double> knots, double period);

  /// Number of coefficients r_i: as many as knots if closed, two more if open.
  [[nodiscard]] std::size_t count() const { return closed() ? knots_.size() : knots_.size() + 2; }
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }
  [[nodiscard]] double period() const { return period_; }
  [[nodiscard]] bool closed() const { return period_ > 0.0; }
  /// Number of intervals between knots.
  [[nodiscard]] std::size_t intervals() const { return closed() ? knots_.size() : knots_.size() - 1; }

  /// x brought into the range that the knots span: modulo the period, or the nearer end.
  [[nodiscard]] double Wrap(double x) const;
  /// The interval that holds a wrapped x.
  [[nodiscard]] std::size_t Interval(double wrapped) const;
  /// Knot `offset` places after the first of an interval, -2 … 3, in the interval's own turn.
  [[nodiscard]] double Knot(std::size_t interval, std::ptrdiff_t offset) const;
  /// Place in knots() of the same knot (a repeated end knot is the end).
  [[nodiscard]] std::size_t KnotIndex(std::size_t interval, std::ptrdiff_t offset) const;
  /// The coefficient that weighs spline k = 0 … 3 of an interval.
  [[nodiscard]] std::size_t Coefficient(std::size_t interval, std::size_t k) const;
  /// Knots interval - 2 … interval + 3.
  [[nodiscard]] std::array<double, 6> LocalKnots(std::size_t interval) const;

  /// f(x) with these coefficients.
  [[nodiscard]] double Value(const Eigen::VectorXd& coefficients, double x) const;

 private:
  std::vector<double> knots_;
  double period_;
};

/// A fitted curve and the parts of its cost (eq. 2.4).
struct CurveFit {
  Eigen::VectorXd coefficients;  ///< r_i, mm.
  double squared_error = 0.0;    ///< Σ w [f(x_k) - r_k]², mm².
  double bending = 0.0;          ///< ∫ f''(x)² dx.
};

/// Fits curves with one basis and one lambda to values at the same places x:
///   sigma = Σ w_k [f(x_k) - r_k]² + lambda ∫ f''(x)² dx                                     (paper 001, eq. 2.4)
/// The paper prints f'² without lambda; by its eq. 2.2 the quadratic variation is meant. lambda has the unit rad³ for
/// x = theta and mm³ for x = z. Holes are bridged by the second term. Thread-bound.
class CurveFitter {
 public:
  CurveFitter(KnotSplineBasis basis, std::vector<double> x, double lambda);

  [[nodiscard]] const KnotSplineBasis& basis() const { return basis_; }
  [[nodiscard]] double lambda() const { return lambda_; }

  /// Minimises eq. 2.4; one value and weight per x. Fails if they do not determine a curve (fewer than two places).
  [[nodiscard]] Result<CurveFit> Fit(std::span<const double> values, std::span<const double> weights);

  /// Sd of f(x) per unit of noise of one sample, when all samples have weight 1.
  [[nodiscard]] double NoiseGain(double x) const;
  /// Trace of the hat matrix, when the samples have these weights: how many parameters the curve spends.
  [[nodiscard]] double EffectiveParameters(std::span<const double> weights) const;

 private:
  [[nodiscard]] Eigen::SparseMatrix<double> NormalMatrix(std::span<const double> weights) const;

  KnotSplineBasis basis_;
  double lambda_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows_;  ///< N_{i,4}(x_k).
  Eigen::SparseMatrix<double> bending_;                ///< ∫ N_i'' N_j''.
  std::vector<double> factored_weights_;
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> factor_;
};

/// The lambda of eq. 2.4 that generalised cross-validation prefers for one curve, on a grid of half decades. Never so
/// small that the equations lose their precision.
[[nodiscard]] double ChooseLambda(const KnotSplineBasis& basis, const CurveSamples& samples);

}  // namespace annulus
