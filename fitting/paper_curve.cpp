#include "fitting/paper_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "fitting/local_cubic_basis.h"

namespace annulus {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

Eigen::SparseMatrix<double, Eigen::RowMajor> BasisRows(const KnotSplineBasis& basis, std::span<const double> x) {
  Triplets entries;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double at = basis.Wrap(x[k]);
    const std::size_t interval = basis.Interval(at);
    const std::array<double, 4> n = LocalCubicBasis(basis.LocalKnots(interval), at);
    for (std::size_t i = 0; i < 4; ++i) {
      entries.emplace_back(static_cast<int>(k), static_cast<int>(basis.Coefficient(interval, i)), n[i]);
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows(static_cast<Eigen::Index>(x.size()),
                                                    static_cast<Eigen::Index>(basis.count()));
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

/// ∫ N_i'' N_j'': the integrand is quadratic between knots, so two Gauss points are exact.
Eigen::SparseMatrix<double> BendingMatrix(const KnotSplineBasis& basis) {
  Triplets entries;
  for (std::size_t interval = 0; interval < basis.intervals(); ++interval) {
    const std::array<double, 6> knots = basis.LocalKnots(interval);
    const double half = 0.5 * (knots[3] - knots[2]);
    for (const double sign : {-1.0, 1.0}) {
      const std::array<double, 4> second = LocalCubicSecond(knots, knots[2] + half * (1.0 + sign / std::sqrt(3.0)));
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          entries.emplace_back(static_cast<int>(basis.Coefficient(interval, i)),
                               static_cast<int>(basis.Coefficient(interval, j)), half * second[i] * second[j]);
        }
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(basis.count());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Eigen::Map<const Eigen::VectorXd> AsVector(std::span<const double> values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

KnotSplineBasis::KnotSplineBasis(std::vector<double> knots, double period) : knots_(std::move(knots)), period_(period) {
  ENSURE(knots_.size() >= (closed() ? 4U : 2U), "a spline has enough knots");
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    ENSURE(std::isfinite(knots_[k]) && (k == 0 || knots_[k - 1] < knots_[k]), "knots are finite and increase");
  }
  ENSURE(!closed() || knots_.back() < knots_.front() + period_, "closed knots lie within one period");
}

double KnotSplineBasis::Wrap(double x) const {
  if (!closed()) return std::clamp(x, knots_.front(), knots_.back());
  const double turns = std::floor((x - knots_.front()) / period_);
  const double wrapped = x - turns * period_;
  return wrapped < knots_.front() + period_ ? std::max(wrapped, knots_.front()) : knots_.front();
}

std::size_t KnotSplineBasis::Interval(double wrapped) const {
  const auto last = closed() ? knots_.end() : knots_.end() - 1;
  const auto above = std::upper_bound(knots_.begin() + 1, last, wrapped);
  return static_cast<std::size_t>(above - knots_.begin()) - 1;
}

std::size_t KnotSplineBasis::KnotIndex(std::size_t interval, std::ptrdiff_t offset) const {
  const auto n = static_cast<std::ptrdiff_t>(knots_.size());
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(interval) + offset;
  return static_cast<std::size_t>(closed() ? (at % n + n) % n : std::clamp<std::ptrdiff_t>(at, 0, n - 1));
}

double KnotSplineBasis::Knot(std::size_t interval, std::ptrdiff_t offset) const {
  const double knot = knots_[KnotIndex(interval, offset)];
  if (!closed()) return knot;
  const auto n = static_cast<std::ptrdiff_t>(knots_.size());
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(interval) + offset;
  return knot + period_ * static_cast<double>(at < 0 ? -1 : at / n);  // fewer than a turn before the first
}

std::size_t KnotSplineBasis::Coefficient(std::size_t interval, std::size_t k) const {
  return closed() ? (interval + k + knots_.size() - 1) % knots_.size() : interval + k;
}

std::array<double, 6> KnotSplineBasis::LocalKnots(std::size_t interval) const {
  std::array<double, 6> local{};
  for (std::size_t k = 0; k < 6; ++k) local[k] = Knot(interval, static_cast<std::ptrdiff_t>(k) - 2);
  return local;
}

double KnotSplineBasis::Value(const Eigen::VectorXd& coefficients, double x) const {
  const double at = Wrap(x);
  const std::size_t interval = Interval(at);
  const std::array<double, 4> n = LocalCubicBasis(LocalKnots(interval), at);
  double value = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    value += n[k] * coefficients[static_cast<Eigen::Index>(Coefficient(interval, k))];
  }
  return value;
}

CurveFitter::CurveFitter(KnotSplineBasis basis, std::vector<double> x, double lambda)
    : basis_(std::move(basis)), lambda_(lambda), rows_(BasisRows(basis_, x)), bending_(BendingMatrix(basis_)) {
  ENSURE(lambda > 0.0 && std::isfinite(lambda), "lambda is positive");
}

Eigen::SparseMatrix<double> CurveFitter::NormalMatrix(std::span<const double> weights) const {
  const Eigen::SparseMatrix<double> weighted = rows_.transpose() * AsVector(weights).asDiagonal() * rows_;
  return weighted + lambda_ * bending_;
}

Result<CurveFit> CurveFitter::Fit(std::span<const double> values, std::span<const double> weights) {
  const auto n = static_cast<std::size_t>(rows_.rows());
  ENSURE(values.size() == n && weights.size() == n, "one value and weight per place");
  if (factor_ == nullptr || !std::equal(weights.begin(), weights.end(), factored_weights_.begin())) {
    factor_ = std::make_unique<Factor>(NormalMatrix(weights));
    factored_weights_.assign(weights.begin(), weights.end());
  }
  const auto good = std::count_if(weights.begin(), weights.end(), [](double w) { return w > 0.0; });
  Eigen::VectorXd weighted(static_cast<Eigen::Index>(n));
  for (std::size_t k = 0; k < n; ++k) {
    weighted[static_cast<Eigen::Index>(k)] = weights[k] > 0.0 ? weights[k] * values[k] : 0.0;
  }
  CurveFit fit;
  if (good >= 2 && factor_->info() == Eigen::Success) {
    fit.coefficients = factor_->solve(rows_.transpose() * weighted);
  }
  if (fit.coefficients.size() == 0 || !fit.coefficients.allFinite()) {
    return Fail("fit a curve (eq. 2.4)", std::to_string(good) + " returns do not determine it", "scan again");
  }
  const Eigen::VectorXd fitted = rows_ * fit.coefficients;
  for (std::size_t k = 0; k < n; ++k) {
    if (weights[k] <= 0.0) continue;
    const double error = fitted[static_cast<Eigen::Index>(k)] - values[k];
    fit.squared_error += weights[k] * error * error;
  }
  fit.bending = std::max(0.0, fit.coefficients.dot(bending_ * fit.coefficients));
  return fit;
}

double CurveFitter::NoiseGain(double x) const {
  const std::vector<double> ones(static_cast<std::size_t>(rows_.rows()), 1.0);
  const Factor factor(NormalMatrix(ones));
  const std::array<double, 1> place{x};
  const Eigen::VectorXd row = BasisRows(basis_, place).row(0).transpose();
  return (rows_ * factor.solve(row)).norm();
}

double CurveFitter::EffectiveParameters(std::span<const double> weights) const {
  const Eigen::SparseMatrix<double> data = rows_.transpose() * AsVector(weights).asDiagonal() * rows_;
  const Factor factor(NormalMatrix(weights));
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return factor.solve(Eigen::MatrixXd(data)).trace();
}

double ChooseLambda(const KnotSplineBasis& basis, const CurveSamples& samples) {
  constexpr int kFirst = -14;  // half decades about the lambda at which both terms of eq. 2.4 weigh the same
  constexpr int kLast = 6;
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = BasisRows(basis, samples.x);
  const Eigen::SparseMatrix<double> data = rows.transpose() * AsVector(samples.weight).asDiagonal() * rows;
  const double balance = data.diagonal().sum() / BendingMatrix(basis).diagonal().sum();
  const auto good =
      static_cast<double>(std::count_if(samples.weight.begin(), samples.weight.end(), [](double w) { return w > 0; }));
  double best_score = std::numeric_limits<double>::infinity();
  double best = balance;
  for (int half_decade = kFirst; half_decade <= kLast; ++half_decade) {
    CurveFitter fitter(basis, samples.x, balance * std::pow(10.0, 0.5 * half_decade));
    const auto fit = fitter.Fit(samples.value, samples.weight);
    if (!fit) continue;
    const double left = good - fitter.EffectiveParameters(samples.weight);
    const double score = left > 0.0 ? good * fit->squared_error / (left * left) : best_score;
    if (score < best_score) {
      best_score = score;
      best = fitter.lambda();
    }
  }
  return best;
}

}  // namespace annulus
