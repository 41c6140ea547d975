#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fitting/spline_system.h"

namespace annulus {

/// Where Huber's loss turns from square to linear, in local standard deviations.
inline constexpr double kHuberWidth = 5.0;

/// The robust cost ½ Σ w_k s_k² ρ((y_k − B_k c)²/(σ s_k)²) + ½ cᵀPc, less its quadratic minimum, as a function of y
/// with c = c0 + A^{-1/2} y: A is the quadratic problem's matrix, factored by `factor`, and c0 its solution `start`.
/// There the quadratic part is ½‖y‖², and only samples in the linear part of the loss add to it. Borrows all.
class RobustCost {
 public:
  struct Value {
    double cost = 0.0;
    Eigen::VectorXd gradient;
  };

  /// `scales` s_k >= 1, one per row of the system.
  RobustCost(const SplineSystem& system, const FrontalCholesky& factor, const Eigen::VectorXd& start,
             std::span<const double> scales)
      : system_(system), factor_(factor), start_(start), scales_(scales), start_residuals_(system.Residuals(start)) {}

  /// c at y.
  [[nodiscard]] Eigen::VectorXd Coefficients(const Eigen::VectorXd& y) const;
  /// y_k − B_k c for every row, mm.
  [[nodiscard]] Eigen::VectorXd Residuals(const Eigen::VectorXd& y) const;
  [[nodiscard]] Value At(const Eigen::VectorXd& y) const;
  [[nodiscard]] int size() const { return static_cast<int>(start_.size()); }
  /// ρ' of every row: its weight in the equivalent least-squares problem.
  [[nodiscard]] std::vector<double> Factors(const Eigen::VectorXd& residuals) const;

 private:
  const SplineSystem& system_;
  const FrontalCholesky& factor_;
  const Eigen::VectorXd& start_;
  std::span<const double> scales_;
  Eigen::VectorXd start_residuals_;
};

}  // namespace annulus
