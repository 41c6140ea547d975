#pragma once

#include <Eigen/SparseCore>

#include "fitting/adaptive_fit.h"
#include "fitting/fit_input.h"

namespace annulus {

/// What the residuals of an adaptive fit say about its uncertainty. S is the smoother that takes the radii to the
/// fitted ones with the weights as they were chosen, twicing included.
struct FitUncertainty {
  double effective_parameters = 0.0;  ///< trace S
  /// Sd of a return about the surface, mm: the residuals' squares over their expectation, n − 2 trace S + trace SSᵀ
  /// (Buja, Hastie, Tibshirani 1989), both without the returns that are more than four sd away.
  double noise_sigma = 0.0;
  double rms = 0.0;  ///< Of the residuals, mm.
  /// Sd of detail that the smoothing takes away beyond what the posterior expects, mm. Detail makes the residuals of
  /// neighbours alike, noise does not: the mean product of neighbours' residuals around and upwards, less what noise
  /// alone makes of it, brought from one cell's distance to none by the correlation that the posterior gives its own
  /// bias; shrunk towards 0 by its own error (positive-part James–Stein). From places where the surface averages over
  /// more than four returns. Detail finer than the cells counts as noise: nothing tells them apart.
  double detail_sigma = 0.0;
};

/// Estimates all three with four draws of noise of a fixed seed that are smoothed like the radii.
[[nodiscard]] FitUncertainty AssessUncertainty(const FitInput& input, const AdaptiveFit& fit);

/// Upper triangle of the posterior precision of the active coefficients, whose posterior covariance of the radii is
/// σ²S: the Bayesian band of a linear smoother, which counts noise and bias (Wahba 1983, Nychka 1988). After m
/// smoothings, 1 − S goes with penalty P and data matrix G like (P/(G + P))^m; this is a single smoothing with P/m,
/// which agrees where smoothing is strong, times the ratio of both variances of a bilaplacian penalty in the plane,
/// 2Γ(m + ½)/(√(πm) Γ(m)), which is 1.094 for m = 4.
[[nodiscard]] Eigen::SparseMatrix<double> PosteriorPrecision(const AdaptiveFit& fit, double noise_sigma);

}  // namespace annulus
