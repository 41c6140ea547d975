#pragma once

#include <string>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "fitting/uniform_problem.h"

namespace annulus {

/// What a uniform fit found.
struct UniformFit {
  SplineSurface surface;
  TensorMatrix equations;             ///< Σ wfBᵀB/σ² + H + S at the solution.
  SmoothingWeights smoothing;         ///< Multiples of the weight of one cell's samples.
  double effective_parameters = 0.0;  ///< Trace of the hat matrix of the complete grid, times the share seen.
  double noise_sigma_mm = 0.0;        ///< sqrt(Σ f r²/(used − effective parameters)).
  double rms_mm = 0.0;                ///< Of the used samples' residuals.
  double cost_start = 0.0;            ///< Robust cost of the least-squares solution, and at the end.
  double cost_end = 0.0;
  int iterations = 0;  ///< Of the robust steps; 0 when no residual is wild.
  std::string termination = "converged";
};

/// One uniform grid of knots, paper 001 eq. 2.2 with one smoothing weight each way:
///   min_c  ½ Σ w s²ρ((y − Bc)²/(σs)²) + ½ cᵀ(H + S)c,  ρ Huber's with width 5, s >= 1 the local scale.
/// The weights come from ChooseSmoothing; the equations are solved by one band factorisation; residuals beyond 5 local
/// standard deviations are then brought to rest with the same factor by Huber's modified residuals (Huber, Dutter
/// 1974). `z_intervals` >= 4, `theta_count` >= 8. Fails if the equations are singular or their band takes over 2 GB.
[[nodiscard]] Result<UniformFit> FitUniform(const UniformInput& input, std::size_t theta_count,
                                            std::size_t z_intervals);

}  // namespace annulus
