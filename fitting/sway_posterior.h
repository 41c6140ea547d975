#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "fitting/sway_motion.h"

namespace annulus {

/// What one level says of the motion at its time, once the shape of the body at its height is known: the quadratic form
/// −½ mᵀ·information·m + mᵀ·right, m = motion + shape(z).
struct LevelEvidence {
  double time_s = 0.0;
  double z = 0.0;  ///< mm
  SwayMatrix information = SwayMatrix::Zero();
  SwayVector right = SwayVector::Zero();
};

/// What one reading of a fixed sensor says: miss = by·(motion + shape(z)) + the sensor's own offset + noise.
struct RangeEvidence {
  double time_s = 0.0;
  double z = 0.0;  ///< Of the place it looks at, mm.
  SwayVector by = SwayVector::Zero();
  double miss = 0.0;   ///< mm
  double sigma = 1.0;  ///< mm
  std::size_t sensor = 0;
};

/// How people sway, before this one was seen: the axes of the motion are independent Gaussian processes over time, each
/// the sum of two Matérn-3/2 processes of the same proportion. The sizes are those of a typical person times an own
/// scale, which is log-normal; yaw and shift have a further scale each.
struct SwayPrior {
  double fast_s = 1.2;  ///< Time scales.
  double slow_s = 12.0;
  double fast_x = 1.23;         ///< sd of the fast part of lean_x, mm: fast and slow from the ranges of quiet standing
  double slow_x = 2.13;         ///< over 4, 8 and 12 s.
  double forward = 1.675;       ///< y over x.
  double yaw = 0.001;           ///< rad of yaw per mm of lean_x.
  double shift = 0.1;           ///< mm of shift per mm of lean.
  double scale_spread = 0.45;   ///< sd of the logarithm of a person's scale.
  double further_spread = 1.0;  ///< The same of the further scales.
};

/// The motion over time given all evidence.
struct SwayPosterior {
  std::vector<double> times;   ///< Knots, s; linear between them.
  Eigen::VectorXd mean;        ///< By axis: lean_x at all knots, then lean_y …
  Eigen::MatrixXd covariance;  ///< Full: with what the evidence does not tell, such as the part common to all sweeps.
  /// Motions drawn from the posterior with a fixed seed, one per column.
  Eigen::MatrixXd draws;
  double scale = 1.0;      ///< Of the person, posterior mean; 1 is typical.
  double yaw_scale = 1.0;  ///< The likeliest further scales.
  double shift_scale = 1.0;

  /// Weights of the knots about a time: index of the first of two, and the share of the second.
  struct Place {
    std::size_t knot = 0;
    double share = 0.0;
  };
  [[nodiscard]] Place At(double time_s) const;
  [[nodiscard]] SwayMotion MeanAt(double time_s) const;
};

/// All evidence on one scan.
struct SwayEvidence {
  std::vector<LevelEvidence> levels;
  std::vector<RangeEvidence> ranges;
  double begin_s = 0.0;  ///< Time of the first and the last level.
  double end_s = 0.0;
  double shape_step = 10.0;  ///< Distance of heights between which the body's shape is a straight line, mm.
};

/// What is asked for.
enum class SwayDetail {
  kMean,  ///< The mean for the likeliest scale: on the way to a better linearisation.
  kAll,   ///< With covariance and draws, all scales mixed.
};

/// The posterior of the motion, the body's shape at every height being unknown (flat) and the person's scale
/// integrated over. Linear algebra of some hundred unknowns: tenths of a second. Deterministic.
[[nodiscard]] SwayPosterior SolveSway(const SwayEvidence& evidence, const SwayPrior& prior, SwayDetail detail);

}  // namespace annulus
