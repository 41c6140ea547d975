#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"

namespace annulus {

class HierarchicalSpline;

/// One entry of a sparse gradient.
struct CoefficientWeight {
  std::size_t index = 0;
  double weight = 0.0;
};

/// Posterior covariance A⁻¹ of a surface's coefficients, from its normal matrix. Thread-bound.
class SurfaceCovariance {
 public:
  /// Factorises the upper triangle of a symmetric positive definite matrix. Fails if it is not.
  static Result<SurfaceCovariance> FromNormalMatrix(const Eigen::SparseMatrix<double>& upper);
  /// The same for the active coefficients of a hierarchical spline: by its elimination tree, several times faster.
  /// Borrows the spline only during the call.
  static Result<SurfaceCovariance> FromNormalMatrix(const Eigen::SparseMatrix<double>& upper,
                                                    const HierarchicalSpline& basis);

  SurfaceCovariance(SurfaceCovariance&&) noexcept;
  SurfaceCovariance& operator=(SurfaceCovariance&&) noexcept;
  ~SurfaceCovariance();

  /// Variance gᵀA⁻¹g of a quantity with gradient g with respect to the coefficients.
  [[nodiscard]] double Variance(const Eigen::VectorXd& gradient) const;

  /// The variances of several quantities, in less time than one by one.
  [[nodiscard]] std::vector<double> Variances(std::span<const Eigen::VectorXd> gradients) const;

  /// B·signs with B·Bᵀ = A⁻¹: a deviation of the coefficients as likely as the true ones' from their estimate, if
  /// `signs` are independent with mean 0 and variance 1. Size of the coefficients.
  [[nodiscard]] Eigen::VectorXd Deviation(const Eigen::VectorXd& signs) const;

  /// The same for a gradient with few entries, all pairs of which have entries in the normal matrix (coefficients that
  /// act at one place): uses the entries of A⁻¹ on the factor's pattern (Takahashi's recursion), made at the first
  /// call.
  [[nodiscard]] double LocalVariance(std::span<const CoefficientWeight> gradient) const;

 private:
  class Factor;
  class SimplicialFactor;
  class FrontFactor;
  explicit SurfaceCovariance(std::unique_ptr<Factor> factor);
  std::unique_ptr<Factor> factor_;
};

}  // namespace annulus
