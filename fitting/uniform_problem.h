#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/bspline_basis.h"
#include "fitting/cell_grid.h"
#include "fitting/sample_screening.h"
#include "fitting/separable_smoothing.h"
#include "fitting/tensor_matrix.h"

namespace annulus {

/// Where a sample lies among uniform knots, and the four splines each way that act there.
struct TensorPlace {
  std::size_t theta_interval = 0;
  std::size_t z_interval = 0;
  std::array<double, 4> theta{};
  std::array<double, 4> z{};
};

/// Periodic by clamped cubic B-splines on uniform knots, evaluated by one polynomial per interval.
class UniformTensorBasis {
 public:
  /// Requires theta_count >= 8, z_min < z_max, z_intervals >= 1.
  UniformTensorBasis(std::size_t theta_count, double z_min, double z_max, std::size_t z_intervals);

  [[nodiscard]] const PeriodicCubicBasis& theta() const { return theta_; }
  [[nodiscard]] const ClampedCubicBasis& z() const { return z_; }
  [[nodiscard]] std::size_t size() const { return theta_.count() * z_.count(); }
  /// The splines at (theta, z); heights outside count as the nearest end.
  [[nodiscard]] TensorPlace At(double theta, double z) const;
  /// Index of the coefficient of local spline `k` (0 … 3) around.
  [[nodiscard]] std::size_t Column(std::size_t interval, std::size_t k) const { return column_[interval + k]; }
  /// Σ z_b theta_a c_ab.
  [[nodiscard]] double Value(const TensorPlace& place, const Eigen::VectorXd& coefficients) const;
  /// c_ab += factor · z_b theta_a.
  void AddTransposed(const TensorPlace& place, double factor, Eigen::VectorXd& coefficients) const;

 private:
  PeriodicCubicBasis theta_;
  ClampedCubicBasis z_;
  double intervals_per_rad_;
  double intervals_per_mm_;
  std::vector<std::size_t> column_;
  std::vector<std::array<double, 16>> z_polynomials_;  ///< By interval: powers of the place in it, splines fastest.
};

/// What a uniform fit is made of. Borrows all of it.
struct UniformInput {
  std::span<const SurfaceSample> samples;
  std::span<const SampleVerdict> verdicts;  ///< Good samples are used.
  const CellGrid& cells;
  double noise_sigma = 0.0;  ///< mm, > 0
};

/// The normal equations of a uniform tensor spline c about the mean radius r₀:
///   min_c  ½ Σ w_k (y_k − r₀ − B_k c)²/σ² + ½ cᵀ(H + S)c,
/// where H is a weak pull to level ground in the cells without samples (kHoleSlope) and S the roughness by weights
/// that are chosen on the complete grid of cells. Every sample keeps its own theta and z. Borrows its input.
class UniformProblem {
 public:
  UniformProblem(const UniformInput& input, std::size_t theta_count, std::size_t z_intervals);

  [[nodiscard]] const UniformTensorBasis& basis() const { return basis_; }
  [[nodiscard]] const UniformInput& input() const { return input_; }
  [[nodiscard]] double mean_radius() const { return mean_radius_; }
  /// Indices of the used samples, by interval of z.
  [[nodiscard]] const std::vector<std::uint32_t>& used() const { return used_; }
  /// Radius of sample `index` over the mean, mm.
  [[nodiscard]] double Height(std::size_t index) const { return input_.samples[index].radius - mean_radius_; }
  [[nodiscard]] TensorPlace Place(std::size_t index) const {
    return basis_.At(input_.samples[index].theta, input_.samples[index].z);
  }

  /// y_k − r₀ − B_k c of the used samples, mm, in their order.
  [[nodiscard]] std::vector<double> Residuals(const Eigen::VectorXd& coefficients) const;

  /// Σ w BᵀB/σ².
  [[nodiscard]] const TensorMatrix& data() const { return data_; }
  /// Σ w Bᵀ(y − r₀)/σ².
  [[nodiscard]] const Eigen::VectorXd& right() const { return right_; }

  /// The weights by generalised cross-validation on the cells, gaps bridged by straight lines; as multiples of the
  /// weight of one cell's samples.
  [[nodiscard]] SmoothingWeights ChooseSmoothing() const;
  /// H + S, and 1e-10 of the data's mean diagonal on the diagonal.
  [[nodiscard]] TensorMatrix Penalty(const SmoothingWeights& weights) const;
  /// Calls `visit` with the rows v of which H + S (without the small diagonal) is the sum Σ weight·v vᵀ.
  void ForPenaltyRows(const SmoothingWeights& weights,
                      const std::function<void(const TensorPlace& row, double weight)>& visit) const;
  /// Share of the cells that hold samples.
  [[nodiscard]] double seen_share() const { return seen_share_; }

 private:
  void SortByInterval();
  void AccumulateData();
  void AddHoles(TensorMatrix& matrix) const;
  [[nodiscard]] GridData ProjectCells() const;

  UniformInput input_;
  UniformTensorBasis basis_;
  double mean_radius_ = 0.0;
  double samples_per_cell_ = 0.0;  ///< Mean over the cells that hold any.
  double seen_share_ = 0.0;
  std::vector<std::uint32_t> used_;
  std::vector<std::uint32_t> first_of_interval_;
  TensorMatrix data_;
  Eigen::VectorXd right_;
  std::vector<CubicBasis> theta_at_column_;
  std::vector<CubicBasis> z_at_row_;
  AxisForms theta_forms_;
  AxisForms z_forms_;
};

}  // namespace annulus
