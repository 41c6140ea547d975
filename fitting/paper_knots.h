#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "fitting/paper_curve.h"
#include "fitting/paper_features.h"

namespace annulus {

/// A curve's knots: every third one is a feature point, the two after it stand between it and the next feature.
struct KnotPlan {
  std::vector<FeaturePoint> features;  ///< In x order; an open curve begins and ends with kEnd.
  std::vector<double> knots;           ///< 3 per feature; an open curve ends with its last feature (3 · features - 2).
  double period = 0.0;
  /// How far the knots between features were drawn from eq. 2.6 (0) towards the evenest spacing (1).
  double evened = 0.0;
  std::size_t dropped = 0;  ///< Features given up so that a uniform parameter can run through the knots.

  [[nodiscard]] bool closed() const { return period > 0.0; }
};

/// What a plan has to keep.
struct KnotRules {
  /// Of a uniform cubic curve through the knots: least slope on any interval, over the interval's mean slope. Above 0
  /// the surface's u and v never turn back.
  double least_slope = 0.3;
  /// Longest stretch between two features, as a share of the curve: twice the mean gap of the paper's 16 features.
  double longest_gap = 1.0 / 8.0;
  std::size_t most_features = 40;
};

/// x1, x2 between x0 and x3 such that ∫|f'| is the same on all three parts (paper 001, eq. 2.6): exactly for the
/// polyline through the known |estimates| of f'; thirds where f' is 0. Requires x0 < x3 (x3 may lie a turn further).
[[nodiscard]] std::array<double, 2> SplitByVariation(const CurveSamples& samples,
                                                     const std::vector<SlopeEstimate>& slopes, double x0, double x3);

/// Where a curve rises least.
struct SlopeMinimum {
  double slope = 1.0;        ///< Over the mean slope of its interval; 1 for equal distances.
  std::size_t interval = 0;  ///< After this knot.
};

/// Least slope of the uniform cubic B-spline curve that runs through the knots (eq. 2.8; open ends as eq. 2.11).
[[nodiscard]] SlopeMinimum LeastSlope(const std::vector<double>& knots, double period);

/// How far the uniform curve through f at the knots (eq. 2.9; v direction: eq. 2.11) passes the samples, after f was
/// fitted with these knots and lambda: Σ w [r(x_k) - r_k]², mm². Infinite if that curve turns back.
[[nodiscard]] double UniformMisfit(const CurveSamples& samples, const std::vector<double>& knots, double lambda);

/// Knots of paper 001, §2: the features, two more between each pair by eq. 2.6. Where the paper is silent:
///   - an open curve's ends are features; stretches longer than `longest_gap` are halved by features of kind kAdded
///     (so a circle, which has no features, gets 8);
///   - more than `most_features`, or a sixth of the samples: the least significant go;
///   - eqs. 2.8–2.10 give every interval the same length in u, so that a curve through knots at very unequal distances
///     bends between them, or even turns back. So the knots between features are drawn towards the positions with the
///     least second differences, by that of nine shares from 0 to 1 with the least UniformMisfit among those that keep
///     `least_slope`. If none does, the longest stretch there is halved by a kAdded; if that would crowd the samples,
///     the less significant feature of the closest pair goes.
/// Requires at least 12 samples.
[[nodiscard]] KnotPlan PlaceKnots(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                                  std::vector<FeaturePoint> features, const KnotRules& rules);

/// Eq. 2.4 as a sum of squares: residuals sqrt(w_k)(f(x_k) - r_k), then sqrt(lambda·weight) f'' at two Gauss points per
/// interval, with their derivatives with respect to the coefficients and to the knots that are not features.
struct KnotResiduals {
  Eigen::VectorXd values;
  Eigen::MatrixXd by_coefficient;
  Eigen::MatrixXd by_knot;  ///< One column per free knot, in order.
};
[[nodiscard]] KnotResiduals EvaluateKnotResiduals(const CurveSamples& samples, const KnotPlan& plan, double lambda,
                                                  const Eigen::VectorXd& coefficients);

/// How the knots between features were moved.
struct KnotMove {
  KnotPlan plan;
  double cost_start = 0.0;  ///< Eq. 2.4 before and after, mm².
  double cost_end = 0.0;
  int iterations = 0;
};

/// Share of the distance to either neighbour within which a knot may move from its first position.
inline constexpr double kKnotRange = 0.2;

/// Moves the knots between features within kKnotRange so that eq. 2.4 falls (ceres::Solver over coefficients and knots
/// together, the knots bounded), features fixed. While the result breaks `rules.least_slope` or raises UniformMisfit by
/// more than a twentieth, the move is halved. cost_end <= cost_start. Fails if the samples do not determine a curve.
[[nodiscard]] Result<KnotMove> MoveKnots(const CurveSamples& samples, const KnotPlan& plan, double lambda,
                                         const KnotRules& rules);

}  // namespace annulus
