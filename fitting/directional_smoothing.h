#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "fitting/spline_system.h"

namespace annulus {

/// Factors on the roughness weights of the two directions; the mixed difference takes their geometric mean.
struct DirectionalSmoothing {
  double theta = 1.0;
  double z = 1.0;
};

/// `weights` with each direction scaled.
[[nodiscard]] RoughnessWeights Scaled(const RoughnessWeights& weights, const DirectionalSmoothing& smoothing);

/// Generalised cross-validation (Craven, Wahba 1979) of the twiced smoother S = 2H − H², H = B A⁻¹ Bᵀ W:
/// n·RSS/(n − trace S)². Traces by probes of a fixed seed, the same at every point, so that the score is smooth.
class DirectionalGcv {
 public:
  /// `factors` weigh the rows: 0 leaves a row out. Borrows all; every leaf of the basis must be plain.
  DirectionalGcv(const SplineSystem& system, std::shared_ptr<const EliminationTree> tree,
                 const RoughnessWeights& weights, std::span<const double> factors);

  /// The score, mm²; infinite where it cannot be told.
  [[nodiscard]] double At(const DirectionalSmoothing& smoothing) const;

 private:
  [[nodiscard]] FrontalCholesky::FourColumns DataTimes(const FrontalCholesky::FourColumns& x) const;

  const SplineSystem& system_;
  std::shared_ptr<const EliminationTree> tree_;
  const RoughnessWeights& weights_;
  std::span<const double> factors_;
  std::vector<TensorForm> data_;         ///< G by leaf.
  double squares_ = 0.0;                 ///< yᵀWy/σ²
  double total_weight_ = 0.0;            ///< Rows that count.
  FrontalCholesky::FourColumns probes_;  ///< The first is not used.
  FrontalCholesky::FourColumns right_;   ///< BᵀWy/σ², then G times the probes.
};

/// Minimises the score over the logarithm of the theta factor, then of the z factor, by a parabola through three points
/// each, moved as far as needed; factors stay within 1/64 … 64.
[[nodiscard]] DirectionalSmoothing ChooseDirectionalSmoothing(const DirectionalGcv& score);

}  // namespace annulus
