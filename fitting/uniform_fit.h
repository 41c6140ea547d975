#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "fitting/uniform_problem.h"

namespace annulus {

/// A sample whose residual stood out, and where Huber's loss turns linear for it: five times its local scale. To all
/// other samples the loss is square.
struct HuberLimit {
  std::uint32_t sample = 0;  ///< Index into the samples given.
  double limit_mm = 0.0;
};

/// What a uniform fit found.
struct UniformFit {
  SplineSurface surface;
  TensorMatrix equations;             ///< Σ wfBᵀB/σ² + H + S at the solution.
  SmoothingWeights smoothing;         ///< Multiples of the weight of one cell's samples.
  double effective_parameters = 0.0;  ///< Trace of the hat matrix of the complete grid, times the share seen.
  double noise_sigma_mm = 0.0;        ///< sqrt(Σ f r²/(used − parameters by 2H − HHᵀ)).
  double rms_mm = 0.0;                ///< Of the used samples' residuals.
  double cost_start = 0.0;            ///< Robust cost of the least-squares solution, and at the end.
  double cost_end = 0.0;
  int iterations = 0;  ///< Of the robust steps; 0 when no residual is wild.
  std::string termination = "converged";
  std::vector<HuberLimit> limits{};
};

/// One uniform grid of knots, paper 001 eq. 2.2 with one smoothing weight each way:
///   min_c  ½ Σ w s²ρ((y − Bc)²/(σs)²) + ½ cᵀ(H + S)c,  ρ Huber's with width 5, s >= 1 the local scale.
/// The weights come from ChooseSmoothing; the equations are solved by one band factorisation; residuals beyond 5 local
/// standard deviations are then brought to rest with the same factor by Huber's modified residuals (Huber, Dutter
/// 1974). Requires `z_intervals` >= 1 and `theta_count` >= 8. Fails with fewer cells than knots either way, if the
/// equations are singular, or if their band takes over 2 GB.
[[nodiscard]] Result<UniformFit> FitUniform(const UniformInput& input, std::size_t theta_count,
                                            std::size_t z_intervals);

/// How ceres::Solve does its linear algebra.
enum class CeresLinearSolver {
  kConjugateGradients,  ///< CGNR.
  kSparseCholesky,      ///< SPARSE_NORMAL_CHOLESKY.
};

/// How ceres::Solve is asked.
struct UniformCeresOptions {
  std::size_t block_width = 4;  ///< Coefficients around per parameter block, >= 3; must divide the number around.
  CeresLinearSolver linear_solver = CeresLinearSolver::kConjugateGradients;
};

/// What ceres::Solve found.
struct UniformCeresFit {
  SplineSurface surface;
  double cost = 0.0;  ///< The same cost as UniformFit::cost_end.
  int iterations = 0;
  std::string termination{};
};

/// Minimises the cost of a uniform fit (its smoothing weights and limits) once more, by ceres::Solve and from `start`
/// (coefficients over the mean radius, mm): a peer of the band solution in tests and benchmarks. Parameter blocks are
/// runs of coefficients of one row of knots; cost functions are the square samples and the penalty of one tile of knot
/// cells, brought to a square root of their local normal equations; samples with a limit are residuals of their own
/// under ceres::HuberLoss.
[[nodiscard]] Result<UniformCeresFit> SolveUniformWithCeres(const UniformProblem& problem, const UniformFit& fit,
                                                            const Eigen::VectorXd& start,
                                                            const UniformCeresOptions& options);

}  // namespace annulus
