#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fitting/robust_cost.h"

namespace annulus {

Eigen::VectorXd RobustCost::Coefficients(const Eigen::VectorXd& y) const {
  return y.isZero(0.0) ? start_ : Eigen::VectorXd(start_ + factor_.SolveUpper(y));
}

bool RobustCost::Evaluate(const double* parameters, double* cost, double* gradient) const {
  const Eigen::Map<const Eigen::VectorXd> y(parameters, NumParameters());
  const Eigen::VectorXd residuals = system_.Residuals(Coefficients(y));
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(residuals.size());
  *cost = 0.5 * y.squaredNorm();
  bool any = false;
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const double scale = system_.noise_sigma() * scales_[index];
    const double residual = residuals[k] / scale;
    if (std::abs(residual) <= kHuberWidth) continue;
    std::array<double, 3> rho{};
    loss_.Evaluate(residual * residual, rho.data());
    const double weight = static_cast<double>(system_.rows()[index].weight) * scales_[index] * scales_[index];
    *cost += 0.5 * weight * (rho[0] - residual * residual);
    slope[k] = -weight * (rho[1] - 1.0) * residual / scale;
    any = true;
  }
  if (gradient != nullptr) {
    Eigen::Map<Eigen::VectorXd> sum(gradient, NumParameters());
    sum = y;
    if (any) sum += factor_.SolveLower(system_.Transpose(slope));
  }
  return std::isfinite(*cost);
}

std::vector<double> RobustCost::Factors(const Eigen::VectorXd& residuals) const {
  std::vector<double> factors(scales_.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double residual = residuals[static_cast<Eigen::Index>(k)] / (system_.noise_sigma() * scales_[k]);
    std::array<double, 3> rho{};
    loss_.Evaluate(residual * residual, rho.data());
    factors[k] = rho[1];
  }
  return factors;
}

PolishResult RobustPolish(const SplineSystem& system, const FrontalCholesky& factor, const Eigen::VectorXd& start,
                          std::span<const double> scales) {
  auto* cost = new RobustCost(system, factor, start, scales);
  const ceres::GradientProblem problem(cost);  // owns the cost
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
  result.coefficients = summary.IsSolutionUsable() ? cost->Coefficients(y) : start;
  result.factors = cost->Factors(system.Residuals(result.coefficients));
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
