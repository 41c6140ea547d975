#pragma once

#include <cstddef>
#include <vector>

#include "fitting/paper_curve.h"

namespace annulus {

/// K of paper 001, eq. 2.5: the local cubic is fitted to 2K + 1 samples.
inline constexpr std::size_t kLocalCubicHalfWidth = 5;
/// Feature points lie at least this many samples apart, since three knots stand between two of them.
inline constexpr std::size_t kSamplesPerFeatureGap = 3;

/// Estimates of f' and f'' at one sample, from the local cubic of eq. 2.5.
struct SlopeEstimate {
  bool known = false;        ///< False in holes and at the very ends, where too few samples lie around.
  double first = 0.0;        ///< f'
  double second = 0.0;       ///< f''
  double first_gain = 0.0;   ///< Sd of f' per unit of noise of one sample, from the least squares' own covariance.
  double second_gain = 0.0;  ///< The same of f''.
};

/// One estimate per sample. The local cubic takes what the 2K + 1 samples around have, at least 7 of 11 and some on
/// both sides.
[[nodiscard]] std::vector<SlopeEstimate> EstimateSlopes(const CurveSamples& samples);

/// Why a feature point is one.
enum class FeatureKind {
  kExtremum,    ///< f' = 0
  kInflection,  ///< f'' = 0
  kEnd,         ///< First or last sample of an open curve.
  kAdded,       ///< Halves a stretch too long to have three knots only (see PlaceKnots).
};

/// A place on a curve that becomes a fixed knot.
struct FeaturePoint {
  FeatureKind kind = FeatureKind::kExtremum;
  double x = 0.0;             ///< The last sample before the sign flips, as in the paper.
  double significance = 0.0;  ///< Lower of the peaks of |f'| (|f''|) on both sides, in its own sd.
};

/// Below this many sd an estimate of f' or f'' may have either sign: exceeded by noise alone in 5 % of curves of
/// `samples` samples (Bonferroni, two-sided).
[[nodiscard]] double SignificanceGate(std::size_t samples);

/// The feature points of a curve: where the estimate of f' (extrema) or f'' (inflections) changes its sign.
/// Noise alone also makes signs flip. So a change counts only between two samples at which the estimate exceeds
/// SignificanceGate times its own sd with opposite signs; of the flips between these two, the one is taken that leaves
/// the least |estimate| on the wrong side. Of two features nearer than kSamplesPerFeatureGap samples the more
/// significant is kept. In x order. `noise_sd`: of one sample, mm, > 0.
[[nodiscard]] std::vector<FeaturePoint> FindFeatures(const CurveSamples& samples,
                                                     const std::vector<SlopeEstimate>& slopes, double noise_sd);

/// How complex a curve is: first the number of its feature points, then its bending. Compared in this order.
struct Complexity {
  std::size_t features = 0;
  double bending = 0.0;  ///< ∫ |f''| dx, from the estimates.

  friend auto operator<=>(const Complexity&, const Complexity&) = default;
};
[[nodiscard]] Complexity MeasureComplexity(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                                           const std::vector<FeaturePoint>& features);

}  // namespace annulus
