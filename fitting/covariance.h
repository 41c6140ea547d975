#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "base/result.h"
#include "fitting/spline_surface.h"

namespace annulus {

/// Posterior covariance A⁻¹ of a surface's coefficients, from its normal matrix. Immutable; reentrant.
class SurfaceCovariance {
 public:
  /// Factorises the upper triangle of a symmetric positive definite matrix. Fails if it is not.
  static Result<SurfaceCovariance> FromNormalMatrix(const Eigen::SparseMatrix<double>& upper);

  SurfaceCovariance(SurfaceCovariance&&) noexcept;
  SurfaceCovariance& operator=(SurfaceCovariance&&) noexcept;
  ~SurfaceCovariance();

  /// Variance gᵀA⁻¹g of a quantity with gradient g with respect to the coefficients.
  [[nodiscard]] double Variance(const Eigen::VectorXd& gradient) const;

  /// Variance of the radius at one place, mm². Uses the entries of A⁻¹ on the factor's pattern (Takahashi's recursion).
  [[nodiscard]] double RadiusVariance(const RadiusRow& row) const;

 private:
  struct Factor;
  explicit SurfaceCovariance(std::unique_ptr<Factor> factor);
  std::unique_ptr<Factor> factor_;
};

}  // namespace annulus
