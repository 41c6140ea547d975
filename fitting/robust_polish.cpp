#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <cmath>

#include "fitting/robust_cost.h"

namespace annulus {

Eigen::VectorXd RobustCost::Coefficients(const Eigen::VectorXd& y) const {
  return y.isZero(0.0) ? start_ : Eigen::VectorXd(start_ + factor_.SolveUpper(y));
}

Eigen::VectorXd RobustCost::Residuals(const Eigen::VectorXd& y) const {
  return y.isZero(0.0) ? start_residuals_ : system_.Residuals(Coefficients(y));
}

RobustCost::Value RobustCost::At(const Eigen::VectorXd& y) const {
  const Eigen::VectorXd residuals = Residuals(y);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(residuals.size());
  Value value{0.5 * y.squaredNorm(), y};
  bool any = false;
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const double scale = system_.noise_sigma() * scales_[index];
    const double residual = residuals[k] / scale;
    const double excess = std::abs(residual) - kHuberWidth;
    if (excess <= 0.0) continue;
    // Huber's ρ = 2w|t| − w² is t² less the square of the excess.
    const double weight = static_cast<double>(system_.rows()[index].weight) * scales_[index] * scales_[index];
    value.cost -= 0.5 * weight * excess * excess;
    slope[k] = weight * std::copysign(excess, residual) / scale;
    any = true;
  }
  if (any) value.gradient += factor_.SolveLower(system_.Transpose(slope));
  return value;
}

std::vector<double> RobustCost::Factors(const Eigen::VectorXd& residuals) const {
  std::vector<double> factors(scales_.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double size = std::abs(residuals[static_cast<Eigen::Index>(k)]) / (system_.noise_sigma() * scales_[k]);
    factors[k] = size > kHuberWidth ? kHuberWidth / size : 1.0;
  }
  return factors;
}

namespace {

/// The cost as Ceres takes it.
class CeresCost final : public ceres::FirstOrderFunction {
 public:
  explicit CeresCost(const RobustCost& cost) : cost_(cost) {}
  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const RobustCost::Value value = cost_.At(Eigen::Map<const Eigen::VectorXd>(parameters, cost_.size()));
    *cost = value.cost;
    if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, cost_.size()) = value.gradient;
    return std::isfinite(*cost);
  }
  [[nodiscard]] int NumParameters() const override { return cost_.size(); }

 private:
  const RobustCost& cost_;
};

}  // namespace

PolishResult RobustPolish(const SplineSystem& system, const FrontalCholesky& factor, const Eigen::VectorXd& start,
                          std::span<const double> scales) {
  const RobustCost cost(system, factor, start, scales);
  const ceres::GradientProblem problem(new CeresCost(cost));  // owns it
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_num_iterations = 40;
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-8;
  options.logging_type = ceres::SILENT;
  Eigen::VectorXd y = Eigen::VectorXd::Zero(start.size());
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, y.data(), &summary);

  PolishResult result;
  if (!summary.IsSolutionUsable()) y.setZero();
  result.coefficients = cost.Coefficients(y);
  result.residuals = cost.Residuals(y);
  result.factors = cost.Factors(result.residuals);
  result.cost_start = summary.initial_cost;
  result.cost_end = summary.final_cost;
  result.iterations = std::max(0, static_cast<int>(summary.iterations.size()) - 1);
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      result.termination = "converged";
      break;
    case ceres::NO_CONVERGENCE:
      result.termination = "iteration limit";
      break;
    default:
      result.termination = "polish failed: " + summary.message;
  }
  return result;
}

}  // namespace annulus
