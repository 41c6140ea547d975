#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/cell_grid.h"
#include "fitting/front_kernels.h"
#include "fitting/frontal_cholesky.h"
#include "fitting/hierarchical_spline.h"
#include "fitting/roughness.h"

namespace annulus {

/// One used sample as a row of the least-squares problem.
struct SampleRow {
  double theta = 0.0;   ///< Place in its leaf, 0 … 1.
  double z = 0.0;       ///< The same upwards.
  double radius = 0.0;  ///< mm
  float weight = 1.0F;  ///< Relative weight of the sample, 1 for an ordinary return.
  std::uint32_t leaf = 0;
  std::uint32_t sample = 0;  ///< Index into the samples that the system was made of.
  std::uint32_t cell = 0;    ///< Of the system's grid of cells.
};

/// The samples that a fit uses and how noisy they are. Borrows the samples.
struct UsedSamples {
  std::span<const SurfaceSample> samples;
  std::vector<char> use;         ///< One flag per sample.
  double noise_sigma = 0.0;      ///< mm, > 0
  std::vector<float> weights{};  ///< One per sample, instead of their own; empty: their own.
};

/// The linear smoothing problem  min_c Σ w_k (y_k − B_k c)²/σ² + cᵀ P c  over the active coefficients of one surface,
/// where cᵀPc is a weighted sum of squared second differences at the cells (roughness.h). Borrows the basis and cells.
class SplineSystem {
 public:
  SplineSystem(const HierarchicalSpline& basis, const UsedSamples& used, const CellGrid& cells);

  [[nodiscard]] const HierarchicalSpline& basis() const { return basis_; }
  [[nodiscard]] const std::vector<SampleRow>& rows() const { return rows_; }  ///< Ordered by leaf.
  [[nodiscard]] double noise_sigma() const { return noise_sigma_; }

  /// B_k c for every row, mm.
  [[nodiscard]] Eigen::VectorXd Predict(const Eigen::VectorXd& coefficients) const;
  /// y_k − B_k c for every row, mm.
  [[nodiscard]] Eigen::VectorXd Residuals(const Eigen::VectorXd& coefficients) const;
  /// Σ_k v_k B_kᵀ.
  [[nodiscard]] Eigen::VectorXd Transpose(const Eigen::VectorXd& values) const;
  /// Σ w_k f_k y_k B_kᵀ / σ² for any values y, with extra factors f (empty: all 1).
  [[nodiscard]] Eigen::VectorXd WeightedTranspose(const Eigen::VectorXd& values, std::span<const double> factors) const;
  /// The radii as a vector, mm.
  [[nodiscard]] Eigen::VectorXd Radii() const;

  /// Second differences of the surface over every cell, mm.
  [[nodiscard]] std::vector<CellBend> Bends(const Eigen::VectorXd& coefficients) const;

  /// Σ w_k f_k B_kᵀB_k/σ² over every leaf's 4 × 4 local coefficients.
  [[nodiscard]] std::vector<TensorForm> DataForms(std::span<const double> factors) const;
  /// What is added to the diagonal of A so that coefficients over holes stay determined.
  [[nodiscard]] double ridge() const;

  /// Factor of A = Σ w_k f_k B_kᵀB_k/σ² + P; nothing if A is not positive definite.
  [[nodiscard]] std::optional<FrontalCholesky> Factor(std::shared_ptr<const EliminationTree> tree,
                                                      const RoughnessWeights& weights,
                                                      std::span<const double> factors) const;
  /// The upper triangle of A; every pair of coefficients that shares a leaf has an entry, zero or not.
  [[nodiscard]] Eigen::SparseMatrix<double> NormalMatrix(const RoughnessWeights& weights,
                                                         std::span<const double> factors) const;

  /// The splines of a row's leaf at the row.
  struct RowSplines {
    std::array<double, 4> theta;
    std::array<double, 4> z;
  };
  [[nodiscard]] RowSplines SplinesAt(const SampleRow& row, const SplineLeaf& leaf) const {
    return {ValuesAt(theta_cubics_, row.theta), ValuesAt(z_cubics_[leaf.level][leaf.z_cell], row.z)};
  }

 private:
  class LeafEquations;

  /// The splines at the cells' centres, by level and by column or row of cells.
  struct CellBases {
    std::vector<std::vector<CubicBasis>> theta;
    std::vector<std::vector<CubicBasis>> z;
  };

  const HierarchicalSpline& basis_;
  const CellGrid& cells_;
  std::vector<SampleRow> rows_;
  std::vector<std::uint32_t> row_first_;   ///< By leaf, one more than leaves.
  std::vector<std::uint32_t> cell_order_;  ///< Cells by leaf.
  std::vector<std::uint32_t> cell_first_;
  CellBases cell_bases_;
  IntervalCubics theta_cubics_ = PeriodicCubicBasis::Cubics();
  std::vector<std::vector<IntervalCubics>> z_cubics_;  ///< By level and z interval.
  double noise_sigma_;
};
/// Outcome of the robust polish.
struct PolishResult {
  Eigen::VectorXd coefficients;
  Eigen::VectorXd residuals;    ///< With these, mm, one per row.
  std::vector<double> factors;  ///< Weight of every row in the equivalent least squares at the solution, 0 … 1.
  double cost_start = 0.0;
  double cost_end = 0.0;
  int iterations = 0;
  std::string termination;
};

/// Minimises ½ Σ w_k s_k² ρ((y_k − B_k c)²/(σ s_k)²) + ½ cᵀ P c with Huber's ρ by ceres::GradientProblemSolver, in the
/// coordinates in which the quadratic problem is the identity (c = c₀ + A^{-1/2} y), so that few steps are needed.
/// `start` c₀ is the solution of the quadratic problem with `factor`; `scales` s_k >= 1, one per row, widen the loss
/// where detail is rough.
[[nodiscard]] PolishResult RobustPolish(const SplineSystem& system, const FrontalCholesky& factor,
                                        const Eigen::VectorXd& start, std::span<const double> scales);

}  // namespace annulus
