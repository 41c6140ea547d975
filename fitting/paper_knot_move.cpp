#include <ceres/ceres.h>
#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "fitting/local_cubic_basis.h"
#include "fitting/paper_knots.h"

namespace annulus {
namespace {

using Jet = ceres::Jet<double, 10>;  // six knots, then four coefficients

std::size_t FreeKnots(const KnotPlan& plan) {
  return 2 * (plan.closed() ? plan.features.size() : plan.features.size() - 1);
}

/// Which free knot a knot is; features are none.
std::ptrdiff_t FreeIndex(std::size_t knot) {
  return knot % 3 == 0 ? -1 : static_cast<std::ptrdiff_t>(2 * (knot / 3) + knot % 3 - 1);
}

/// The local spline of one interval as Jets in its knots and coefficients, and where their derivatives go.
class LocalJets {
 public:
  LocalJets(const KnotSplineBasis& basis, std::size_t interval, const Eigen::VectorXd& coefficients) {
    const std::array<double, 6> local = basis.LocalKnots(interval);
    for (std::size_t k = 0; k < 6; ++k) {
      knots[k] = Jet(local[k], static_cast<int>(k));
      const std::size_t knot = basis.KnotIndex(interval, static_cast<std::ptrdiff_t>(k) - 2);
      free_knot_[k] = FreeIndex(knot);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      coefficient_[k] = static_cast<Eigen::Index>(basis.Coefficient(interval, k));
      weights_[k] = Jet(coefficients[coefficient_[k]], static_cast<int>(6 + k));
    }
  }

  [[nodiscard]] Jet Combine(const std::array<Jet, 4>& splines) const {
    Jet sum(0.0);
    for (std::size_t k = 0; k < 4; ++k) sum += splines[k] * weights_[k];
    return sum;
  }

  void Store(const Jet& residual, Eigen::Index row, KnotResiduals& all) const {
    all.values[row] = residual.a;
    for (std::size_t k = 0; k < 6; ++k) {
      if (free_knot_[k] >= 0) all.by_knot(row, free_knot_[k]) += residual.v[static_cast<Eigen::Index>(k)];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      all.by_coefficient(row, coefficient_[k]) += residual.v[static_cast<Eigen::Index>(6 + k)];
    }
  }

  std::array<Jet, 6> knots;

 private:
  std::array<std::ptrdiff_t, 6> free_knot_{};
  std::array<Jet, 4> weights_;
  std::array<Eigen::Index, 4> coefficient_{};
};

std::vector<double> FreeOf(const KnotPlan& plan) {
  std::vector<double> free;
  for (std::size_t k = 0; k < plan.knots.size(); ++k) {
    if (FreeIndex(k) >= 0) free.push_back(plan.knots[k]);
  }
  return free;
}

KnotPlan WithFree(KnotPlan plan, const double* free) {
  for (std::size_t k = 0; k < plan.knots.size(); ++k) {
    if (FreeIndex(k) >= 0) plan.knots[k] = free[FreeIndex(k)];
  }
  return plan;
}

/// Eq. 2.4 for Ceres: parameter blocks are the coefficients and the free knots.
class SectionCost final : public ceres::CostFunction {
 public:
  SectionCost(const CurveSamples& samples, const KnotPlan& plan, double lambda)
      : samples_(samples), plan_(plan), lambda_(lambda) {
    const KnotSplineBasis basis(plan.knots, plan.period);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(basis.count()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(FreeKnots(plan)));
    set_num_residuals(static_cast<int>(samples.size() + 2 * basis.intervals()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::VectorXd c = Eigen::Map<const Eigen::VectorXd>(parameters[0], parameter_block_sizes()[0]);
    const KnotResiduals all = EvaluateKnotResiduals(samples_, WithFree(plan_, parameters[1]), lambda_, c);
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = all.values;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[0], num_residuals(), c.size()) = all.by_coefficient;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[1], num_residuals(), all.by_knot.cols()) = all.by_knot;
    }
    return true;
  }

 private:
  const CurveSamples& samples_;
  const KnotPlan& plan_;
  double lambda_;
};

Result<double> CostOf(const CurveSamples& samples, const KnotPlan& plan, double lambda) {
  CurveFitter fitter(KnotSplineBasis(plan.knots, plan.period), samples.x, lambda);
  const auto fit = fitter.Fit(samples.value, samples.weight);
  if (!fit) return Fail(fit);
  return fit->squared_error + lambda * fit->bending;
}

}  // namespace

KnotResiduals EvaluateKnotResiduals(const CurveSamples& samples, const KnotPlan& plan, double lambda,
                                    const Eigen::VectorXd& coefficients) {
  const KnotSplineBasis basis(plan.knots, plan.period);
  ENSURE(coefficients.size() == static_cast<Eigen::Index>(basis.count()), "one coefficient per spline");
  const auto rows = static_cast<Eigen::Index>(samples.size() + 2 * basis.intervals());
  KnotResiduals all;
  all.values = Eigen::VectorXd::Zero(rows);
  all.by_coefficient = Eigen::MatrixXd::Zero(rows, coefficients.size());
  all.by_knot = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(FreeKnots(plan)));
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < samples.size(); ++k, ++row) {
    if (samples.weight[k] <= 0.0) continue;
    const double at = basis.Wrap(samples.x[k]);
    const std::size_t interval = basis.Interval(at);
    const LocalJets local(basis, interval, coefficients);
    const Jet value = local.Combine(LocalCubicBasis(local.knots, Jet(at)));
    local.Store(std::sqrt(samples.weight[k]) * (value - samples.value[k]), row, all);
  }
  for (std::size_t interval = 0; interval < basis.intervals(); ++interval) {
    const LocalJets local(basis, interval, coefficients);
    const Jet half = 0.5 * (local.knots[3] - local.knots[2]);
    for (const double sign : {-1.0, 1.0}) {
      const Jet at = local.knots[2] + half * (1.0 + sign / std::sqrt(3.0));
      const Jet second = local.Combine(LocalCubicSecond(local.knots, at));
      local.Store(ceres::sqrt(lambda * half) * second, row++, all);
    }
  }
  return all;
}

Result<KnotMove> MoveKnots(const CurveSamples& samples, const KnotPlan& plan, double lambda, const KnotRules& rules) {
  CurveFitter fitter(KnotSplineBasis(plan.knots, plan.period), samples.x, lambda);
  const auto start = fitter.Fit(samples.value, samples.weight);
  if (!start) return Fail(start);
  KnotMove move;
  move.plan = plan;
  move.cost_start = start->squared_error + lambda * start->bending;
  move.cost_end = move.cost_start;

  Eigen::VectorXd coefficients = start->coefficients;
  const std::vector<double> first = FreeOf(plan);
  std::vector<double> free = first;
  ceres::Problem problem;
  problem.AddResidualBlock(new SectionCost(samples, plan, lambda), nullptr, coefficients.data(), free.data());
  for (std::size_t k = 0; k < plan.knots.size(); ++k) {
    const std::ptrdiff_t index = FreeIndex(k);
    if (index < 0) continue;
    const double before = plan.knots[k - 1];
    const double after = k + 1 < plan.knots.size() ? plan.knots[k + 1] : plan.knots.front() + plan.period;
    const double here = plan.knots[k];
    problem.SetParameterLowerBound(free.data(), static_cast<int>(index), here - kKnotRange * (here - before));
    problem.SetParameterUpperBound(free.data(), static_cast<int>(index), here + kKnotRange * (after - here));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 30;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  move.iterations = static_cast<int>(summary.iterations.size());

  constexpr double kAllowance = 1.05;
  const double misfit = kAllowance * UniformMisfit(samples, plan.knots, lambda);
  for (int halvings = 0; halvings < 8; ++halvings) {
    const KnotPlan moved = WithFree(plan, free.data());
    const bool keeps = LeastSlope(moved.knots, moved.period).slope >= rules.least_slope;
    const auto cost = CostOf(samples, moved, lambda);
    if (keeps && cost && *cost <= move.cost_start && UniformMisfit(samples, moved.knots, lambda) <= misfit) {
      move.plan = moved;
      move.cost_end = *cost;
      return move;
    }
    for (std::size_t k = 0; k < free.size(); ++k) free[k] = 0.5 * (free[k] + first[k]);
  }
  return move;
}

}  // namespace annulus
