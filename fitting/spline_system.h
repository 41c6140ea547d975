#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/spline_surface.h"
#include "fitting/stencil_matrix.h"

namespace annulus {

/// One used sample as a row of the least-squares problem.
struct SampleRow {
  CubicBasis theta;
  CubicBasis z;
  double radius = 0.0;  ///< mm
  double weight = 1.0;  ///< Relative weight of the sample, 1 for an ordinary return.
};

/// The linear smoothing problem  min_c Σ w_k (y_k − B_k c)²/σ² + cᵀ P c  over the coefficients of one surface.
class SplineSystem {
 public:
  SplineSystem(PeriodicCubicBasis theta, ClampedCubicBasis z, std::vector<SampleRow> rows, double noise_sigma);

  [[nodiscard]] const PeriodicCubicBasis& theta() const { return theta_; }
  [[nodiscard]] const ClampedCubicBasis& z() const { return z_; }
  [[nodiscard]] const std::vector<SampleRow>& rows() const { return rows_; }
  [[nodiscard]] std::size_t size() const { return theta_.count() * z_.count(); }
  [[nodiscard]] double noise_sigma() const { return noise_sigma_; }

  /// B_k c for every sample, mm.
  [[nodiscard]] Eigen::VectorXd Predict(const Eigen::VectorXd& coefficients) const;
  /// Σ_k v_k B_kᵀ.
  [[nodiscard]] Eigen::VectorXd Transpose(const Eigen::VectorXd& values) const;
  /// Σ w_k f_k B_kᵀB_k / σ², with extra factors f (empty: all 1).
  [[nodiscard]] StencilMatrix DataMatrix(std::span<const double> factors) const;
  /// Σ w_k f_k y_k B_kᵀ / σ².
  [[nodiscard]] Eigen::VectorXd DataVector(std::span<const double> factors) const;

 private:
  PeriodicCubicBasis theta_;
  ClampedCubicBasis z_;
  std::vector<SampleRow> rows_;
  double noise_sigma_;
};

/// Sparse Cholesky factor of a symmetric positive definite matrix given by its upper triangle.
using SparseFactor = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Upper>;

/// Estimate of trace(A⁻¹ G) with a few ±1 probes of a fixed seed (Hutchinson): the effective parameters of a linear
/// smoother with data matrix G and system matrix A.
[[nodiscard]] double EffectiveParameters(const SparseFactor& factor, const Eigen::SparseMatrix<double>& data_upper);

/// What generalised cross-validation chose.
struct SmoothingChoice {
  double lambda = 0.0;
  double gcv = 0.0;  ///< Score at lambda: n·RSS/(n − edf)².
  double effective_parameters = 0.0;
  Eigen::VectorXd coefficients;
};

/// Minimises the GCV score over log λ for A = G + H + λ·P by a walk in decades and golden section.
/// `fixed` is H (any prior that is not to be chosen), `penalty` is P. Fails if no λ gives a positive definite system.
[[nodiscard]] Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const StencilMatrix& fixed,
                                                      const StencilMatrix& penalty);

/// Outcome of the robust polish.
struct PolishResult {
  Eigen::VectorXd coefficients;
  std::vector<double> factors;  ///< IRLS weight of every sample at the solution, 0 … 1.
  double cost_start = 0.0;
  double cost_end = 0.0;
  int iterations = 0;
  std::string termination;
};

/// Minimises ½ Σ w_k s_k² ρ((y_k − B_k c)²/(σ s_k)²) + ½ cᵀ P c with Huber's ρ by ceres::GradientProblemSolver, in the
/// coordinates in which the quadratic problem is the identity (c = c₀ + A^{-1/2} y), so that few steps are needed.
/// `scales` s_k >= 1 widen the loss where detail is rough.
[[nodiscard]] PolishResult RobustPolish(const SplineSystem& system, const StencilMatrix& penalty,
                                        const SparseFactor& factor, const Eigen::VectorXd& start,
                                        std::span<const double> scales);

}  // namespace annulus
