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
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
};

/// What one reading of a fixed sensor says: miss = by·motion + the sensor's own offset + noise.
struct RangeEvidence {
  double time_s = 0.0;
  Eigen::Vector3d by = Eigen::Vector3d::Zero();
  double miss = 0.0;   ///< mm
  double sigma = 1.0;  ///< mm
  std::size_t sensor = 0;
};

/// How people sway, before this one was seen: x and y at kSwayHeight and yaw are independent Gaussian processes over
/// time, each the sum of two Matérn-3/2 processes, whose sizes are those of a typical person times an own scale. The
/// scale is log-normal.
struct SwayPrior {
  double fast_s = 1.2;         ///< Time scales.
  double slow_s = 12.0;
  double fast_x = 1.23;        ///< sd of the fast part, mm at kSwayHeight: from the ranges of quiet standing over 4, 8
  double slow_x = 2.13;        ///< and 12 s.
  double forward = 1.675;      ///< y over x.
  double yaw = 0.001;          ///< rad of yaw per mm of x.
  double scale_spread = 0.45;  ///< sd of the logarithm of a person's scale.
  double yaw_spread = 1.0;     ///< The same of the scale of the yaw, beside the person's.
};

/// The motion over time given all evidence.
struct SwayPosterior {
  std::vector<double> times;   ///< Knots, s; linear between them.
  Eigen::VectorXd mean;        ///< x at all knots, then y, then yaw.
  Eigen::MatrixXd covariance;  ///< Full: with what the evidence does not tell, such as the part common to all sweeps.
  /// Motions drawn from the posterior with a fixed seed, one per column.
  Eigen::MatrixXd draws;
  double scale = 1.0;      ///< Of the person, posterior mean; 1 is typical.
  double yaw_scale = 1.0;  ///< The likeliest.

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

/// The posterior of the motion, the body's shape at every height being unknown (flat) and the person's scale
/// integrated over. Linear algebra of some hundred unknowns: tenths of a second. Deterministic.
[[nodiscard]] SwayPosterior SolveSway(const SwayEvidence& evidence, const SwayPrior& prior);

}  // namespace annulus
