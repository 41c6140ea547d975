#pragma once

#include <memory>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "fitting/directional_smoothing.h"
#include "fitting/edge_regions.h"
#include "fitting/fit_input.h"
#include "fitting/spline_system.h"

namespace annulus {

/// How often the residuals are smoothed again and added. Cross-validation is for once; two more cost little noise and
/// halve the bias, which girths, being sums, do not average out.
inline constexpr int kTwicings = 3;

/// What an adaptive fit found.
struct AdaptiveFit {
  std::unique_ptr<const HierarchicalSpline> basis;
  std::unique_ptr<const SplineSystem> system;  ///< Borrows the basis and the input.
  std::shared_ptr<const EliminationTree> tree;
  std::optional<FrontalCholesky> factor;    ///< Of the system matrix with the final weights and factors.
  std::vector<std::uint32_t> lone_samples;  ///< Left out by the fit itself, see LoneSamples; ascending.
  RoughnessWeights weights;                 ///< Scaled by `smoothing`.
  DirectionalSmoothing smoothing;
  std::vector<EdgeRegion> edges;  ///< Where the penalty is broken.
  double smoothing_s = 0.0;       ///< Seconds that the cross-validation took, and the polish with twicing.
  double polish_s = 0.0;
  PolishResult polish;           ///< Before twicing.
  Eigen::VectorXd coefficients;  ///< The result.

  /// Factors of the rows at the solution; empty where all are 1.
  [[nodiscard]] std::span<const double> factors() const;
};

/// Local smoothing on a hierarchy that is refined where the residuals are not noise:
///   1. a spline over 4 × 4 cells with weights from the data's second differences; samples that stand alone against it
///      are left out; where its residuals are not noise, it is too coarse;
///   2. where it is not, weights from that surface's own second differences, whose strength each way is chosen by
///      cross-validation; elsewhere the data's weights stay;
///   3. samples with oblique rays are weighed by how far noise along the ray moves the radius;
///   4. cells that are too coarse are split to 2 × 2, then 1 × 1, with a solve between;
///   5. robust polish by Ceres with a local scale; twicing against the smoothing's bias.
[[nodiscard]] Result<AdaptiveFit> FitAdaptive(const FitInput& input, const TaskContext& context);

}  // namespace annulus
