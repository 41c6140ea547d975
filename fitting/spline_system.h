#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/hierarchical_spline.h"

namespace annulus {

/// One used sample as a row of the least-squares problem: the four theta and four z splines of its leaf.
struct SampleRow {
  std::array<double, 4> theta{};
  std::array<double, 4> z{};
  double radius = 0.0;  ///< mm
  float weight = 1.0F;  ///< Relative weight of the sample, 1 for an ordinary return.
  std::uint32_t leaf = 0;
  std::uint32_t sample = 0;  ///< Index into the samples that the system was made of.
};

/// A quadratic form over the coefficients, as one symmetric 16 × 16 block of local coefficients per leaf.
class LeafForms {
 public:
  explicit LeafForms(const HierarchicalSpline& basis) : blocks_(basis.leaves().size(), Block::Zero()) {}

  /// Adds weight · (z ⊗ theta)(z ⊗ theta)ᵀ to a leaf.
  void AddOuter(std::size_t leaf, const std::array<double, 4>& theta, const std::array<double, 4>& z, double weight);
  /// this += factor · other (same basis).
  void Add(const LeafForms& other, double factor);
  /// The upper triangle over the active coefficients; every pair that shares a leaf has an entry, zero or not.
  [[nodiscard]] Eigen::SparseMatrix<double> Assemble(const HierarchicalSpline& basis) const;

 private:
  using Block = Eigen::Matrix<double, 16, 16>;  // upper triangle used
  std::vector<Block> blocks_;
};

/// The linear smoothing problem  min_c Σ w_k (y_k − B_k c)²/σ² + cᵀ P c  over the active coefficients of one surface.
/// Borrows the basis.
class SplineSystem {
 public:
  /// Takes the samples that `use` flags (same length). Requires noise_sigma > 0.
  SplineSystem(const HierarchicalSpline& basis, std::span<const SurfaceSample> samples, const std::vector<char>& use,
               double noise_sigma);

  [[nodiscard]] const HierarchicalSpline& basis() const { return basis_; }
  [[nodiscard]] const std::vector<SampleRow>& rows() const { return rows_; }
  [[nodiscard]] double noise_sigma() const { return noise_sigma_; }

  /// B_k c for every row, mm.
  [[nodiscard]] Eigen::VectorXd Predict(const Eigen::VectorXd& coefficients) const;
  /// y_k − B_k c for every row, mm.
  [[nodiscard]] Eigen::VectorXd Residuals(const Eigen::VectorXd& coefficients) const;
  /// Σ_k v_k B_kᵀ.
  [[nodiscard]] Eigen::VectorXd Transpose(const Eigen::VectorXd& values) const;
  /// Σ w_k f_k B_kᵀB_k / σ², with extra factors f (empty: all 1).
  [[nodiscard]] LeafForms DataForms(std::span<const double> factors) const;
  /// Σ w_k y_k B_kᵀ / σ².
  [[nodiscard]] Eigen::VectorXd DataVector() const;

 private:
  const HierarchicalSpline& basis_;
  std::vector<SampleRow> rows_;  ///< Ordered by leaf.
  double noise_sigma_;
};

/// Sparse Cholesky factor of a symmetric positive definite matrix given by its upper triangle.
using SparseFactor = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Upper>;

/// Adds a share of 1e-10 of the mean diagonal to the diagonal, so that coefficients over holes stay determined.
void AddRidge(Eigen::SparseMatrix<double>& upper);

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
[[nodiscard]] Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const LeafForms& fixed,
                                                      const LeafForms& penalty);

/// Outcome of the robust polish.
struct PolishResult {
  Eigen::VectorXd coefficients;
  std::vector<double> factors;  ///< Weight of every row in the equivalent least squares at the solution, 0 … 1.
  double cost_start = 0.0;
  double cost_end = 0.0;
  int iterations = 0;
  std::string termination;
};

/// Minimises ½ Σ w_k s_k² ρ((y_k − B_k c)²/(σ s_k)²) + ½ cᵀ P c with Huber's ρ by ceres::GradientProblemSolver, in the
/// coordinates in which the quadratic problem is the identity (c = c₀ + A^{-1/2} y), so that few steps are needed.
/// `scales` s_k >= 1, one per row, widen the loss where detail is rough.
[[nodiscard]] PolishResult RobustPolish(const SplineSystem& system, const Eigen::SparseMatrix<double>& penalty_upper,
                                        const SparseFactor& factor, const Eigen::VectorXd& start,
                                        std::span<const double> scales);

}  // namespace annulus
