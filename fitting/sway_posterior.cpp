#include "fitting/sway_posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kKnotStep = 0.25;  // s: a fifth of the fast scale
constexpr std::size_t kMostKnots = 200;
constexpr std::size_t kMostHeights = 200;
constexpr int kDraws = 200;

double Matern(double time, double scale) {
  const double u = std::sqrt(3.0) * std::abs(time) / scale;
  return (1.0 + u) * std::exp(-u);
}

std::vector<double> KnotsOf(double begin, double end) {
  const double length = std::max(end - begin, kKnotStep);
  const auto intervals = std::min(kMostKnots, static_cast<std::size_t>(std::ceil(length / kKnotStep)));
  std::vector<double> knots;
  for (std::size_t k = 0; k <= intervals; ++k) {
    knots.push_back(begin + length * static_cast<double>(k) / static_cast<double>(intervals));
  }
  return knots;
}

SwayPosterior::Place PlaceIn(const std::vector<double>& knots, double value) {
  const double step = (knots.back() - knots.front()) / static_cast<double>(knots.size() - 1);
  const double place = std::clamp((value - knots.front()) / step, 0.0, static_cast<double>(knots.size() - 1));
  const auto knot = std::min(static_cast<std::size_t>(place), knots.size() - 2);
  return {knot, place - static_cast<double>(knot)};
}

/// The evidence with what is of no interest eliminated: a quadratic form in the motion at the knots.
struct Reduced {
  MatrixXd information;
  VectorXd right;
};

/// Sums the evidence over motion (s), shape of the body at heights (c) and offsets of fixed sensors.
class Elimination {
 public:
  Elimination(const SwayEvidence& evidence, const std::vector<double>& knots) : knots_(knots) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const LevelEvidence& level : evidence.levels) {
      low = std::min(low, level.z);
      high = std::max(high, level.z);
    }
    if (!(low < high)) {
      low = 0.0;
      high = 1.0;
    }
    const auto intervals =
        std::clamp<std::size_t>(static_cast<std::size_t>((high - low) / evidence.shape_step), 1, kMostHeights);
    for (std::size_t k = 0; k <= intervals; ++k) {
      heights_.push_back(low + (high - low) * static_cast<double>(k) / static_cast<double>(intervals));
    }
    for (const RangeEvidence& range : evidence.ranges) sensors_ = std::max(sensors_, range.sensor + 1);
    const Index n = 3 * Count(knots_);
    const Index m = 3 * Count(heights_) + static_cast<Index>(sensors_);
    ss_ = MatrixXd::Zero(n, n);
    sc_ = MatrixXd::Zero(n, m);
    cc_ = MatrixXd::Zero(m, m);
    s_ = VectorXd::Zero(n);
    c_ = VectorXd::Zero(m);
    for (const LevelEvidence& level : evidence.levels) Add(level);
    for (const RangeEvidence& range : evidence.ranges) Add(range);
  }

  [[nodiscard]] Reduced Finish() {
    // Nearly flat: a body may be any shape, and a sensor a hand's breadth off.
    constexpr double kShape = 1000.0;  // mm at kSwayHeight; mrad
    constexpr double kOffset = 100.0;  // mm
    const Index shapes = 3 * Count(heights_);
    for (Index k = 0; k < cc_.rows(); ++k) {
      const double sd = k >= shapes ? kOffset : k % 3 == 2 ? 1e-3 * kShape : kShape;
      cc_(k, k) += 1.0 / (sd * sd);
    }
    const Eigen::LLT<MatrixXd> factor(cc_);
    const MatrixXd half = factor.matrixL().solve(sc_.transpose());
    return {ss_ - half.transpose() * half, s_ - half.transpose() * factor.matrixL().solve(c_)};
  }

 private:
  static Index Count(const std::vector<double>& values) { return static_cast<Index>(values.size()); }
  [[nodiscard]] Index Motion(Index axis, std::size_t knot) const {
    return axis * Count(knots_) + static_cast<Index>(knot);
  }

  void Add(const LevelEvidence& level) {
    const auto t = PlaceIn(knots_, level.time_s);
    const auto z = PlaceIn(heights_, level.z);
    const std::array<double, 2> by_t{1.0 - t.share, t.share};
    const std::array<double, 2> by_z{1.0 - z.share, z.share};
    for (Index a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 2; ++i) {
        const Index row = Motion(a, t.knot + i);
        const Index shape = 3 * static_cast<Index>(z.knot + i) + a;
        s_[row] += by_t[i] * level.right[a];
        c_[shape] += by_z[i] * level.right[a];
        for (Index b = 0; b < 3; ++b) {
          for (std::size_t j = 0; j < 2; ++j) {
            const double information = level.information(a, b);
            const Index other = 3 * static_cast<Index>(z.knot + j) + b;
            ss_(row, Motion(b, t.knot + j)) += by_t[i] * by_t[j] * information;
            sc_(row, other) += by_t[i] * by_z[j] * information;
            cc_(shape, other) += by_z[i] * by_z[j] * information;
          }
        }
      }
    }
  }

  void Add(const RangeEvidence& range) {
    const auto t = PlaceIn(knots_, range.time_s);
    const std::array<double, 2> by_t{1.0 - t.share, t.share};
    const double weight = 1.0 / (range.sigma * range.sigma);
    const Index offset = 3 * Count(heights_) + static_cast<Index>(range.sensor);
    cc_(offset, offset) += weight;
    c_[offset] += weight * range.miss;
    for (Index a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 2; ++i) {
        const Index row = Motion(a, t.knot + i);
        s_[row] += weight * by_t[i] * range.by[a] * range.miss;
        sc_(row, offset) += weight * by_t[i] * range.by[a];
        for (Index b = 0; b < 3; ++b) {
          for (std::size_t j = 0; j < 2; ++j) {
            ss_(row, Motion(b, t.knot + j)) += weight * by_t[i] * by_t[j] * range.by[a] * range.by[b];
          }
        }
      }
    }
  }

  std::vector<double> knots_;
  std::vector<double> heights_;
  std::size_t sensors_ = 0;
  MatrixXd ss_, sc_, cc_;
  VectorXd s_, c_;
};

/// The evidence in units of the prior of a typical person: motion = root · unit motion, unit motion ~ N(0, scale²).
struct Whitened {
  MatrixXd root;         ///< Of the covariance of the typical x over time, lower triangle.
  MatrixXd information;  ///< 3n × 3n
  VectorXd right;
  double forward = 1.0;
  double yaw = 1.0;

  [[nodiscard]] VectorXd Scales(double scale, double yaw_scale) const {
    const Index n = root.rows();
    VectorXd d(3 * n);
    d << VectorXd::Constant(n, scale), VectorXd::Constant(n, scale * forward),
        VectorXd::Constant(n, scale * yaw_scale * yaw);
    return d;
  }
  /// Block by block.
  [[nodiscard]] MatrixXd Coloured(const MatrixXd& unit) const {
    const Index n = root.rows();
    MatrixXd result(unit.rows(), unit.cols());
    for (Index a = 0; a < 3; ++a) {
      result.middleRows(a * n, n) = root.triangularView<Eigen::Lower>() * unit.middleRows(a * n, n);
    }
    return result;
  }
};

Whitened Whiten(const Reduced& reduced, const std::vector<double>& knots, const SwayPrior& prior) {
  const auto n = static_cast<Index>(knots.size());
  MatrixXd covariance(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double time = knots[static_cast<std::size_t>(i)] - knots[static_cast<std::size_t>(j)];
      covariance(i, j) = prior.fast_x * prior.fast_x * Matern(time, prior.fast_s) +
                         prior.slow_x * prior.slow_x * Matern(time, prior.slow_s);
    }
  }
  covariance.diagonal().array() += 1e-9;
  Whitened w;
  w.root = Eigen::LLT<MatrixXd>(covariance).matrixL();
  w.forward = prior.forward;
  w.yaw = prior.yaw;
  w.information.resize(3 * n, 3 * n);
  w.right.resize(3 * n);
  for (Index a = 0; a < 3; ++a) {
    w.right.segment(a * n, n) = w.root.transpose() * reduced.right.segment(a * n, n);
    for (Index b = 0; b < 3; ++b) {
      w.information.block(a * n, b * n, n, n) =
          w.root.transpose() * reduced.information.block(a * n, b * n, n, n) * w.root;
    }
  }
  return w;
}

/// The posterior for one pair of scales.
struct Solved {
  VectorXd scales;
  Eigen::LLT<MatrixXd> factor;  ///< Of I + D·information·D.
  VectorXd unit_mean;
  double log_evidence = 0.0;
};

Solved SolveFor(const Whitened& w, double scale, double yaw_scale) {
  Solved s;
  s.scales = w.Scales(scale, yaw_scale);
  MatrixXd b = s.scales.asDiagonal() * w.information * s.scales.asDiagonal();
  b.diagonal().array() += 1.0;
  s.factor.compute(b);
  const VectorXd right = s.scales.cwiseProduct(w.right);
  s.unit_mean = s.factor.solve(right);
  const VectorXd diagonal = MatrixXd(s.factor.matrixL()).diagonal();
  s.log_evidence = 0.5 * right.dot(s.unit_mean) - diagonal.array().log().sum();
  return s;
}

double LogPrior(double logarithm, double spread) { return -0.5 * logarithm * logarithm / (spread * spread); }

std::vector<double> LogScales(double low, double high, double step) {
  std::vector<double> values;
  for (double value = low; value <= high + 1e-9; value += step) values.push_back(value);
  return values;
}

/// Standard normal by Box and Muller.
double Normal(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11U) + 0.5) * 0x1p-53; };
  const double u = uniform();
  return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * uniform());
}

/// Mixes the posteriors of all scales of the person.
SwayPosterior Mix(const Whitened& w, const std::vector<double>& logs, const std::vector<double>& weights,
                  double yaw_scale) {
  constexpr double kLeast = 0.004;  // of the weight: the rest changes nothing
  const Index n = 3 * w.root.rows();
  SwayPosterior posterior;
  posterior.yaw_scale = yaw_scale;
  posterior.scale = 0.0;
  posterior.mean = VectorXd::Zero(n);
  posterior.covariance = MatrixXd::Zero(n, n);
  posterior.draws.resize(n, kDraws);
  std::mt19937_64 random(1);
  double total = 0.0;
  for (const double weight : weights) total += weight > kLeast ? weight : 0.0;
  double share = 0.0;
  Index drawn = 0;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!(weights[k] > kLeast)) continue;
    const double weight = weights[k] / total;
    const Solved solved = SolveFor(w, std::exp(logs[k]), yaw_scale);
    const VectorXd mean = w.Coloured(solved.scales.cwiseProduct(solved.unit_mean));
    const MatrixXd root = w.Coloured(
        solved.scales.asDiagonal() * MatrixXd(solved.factor.matrixU().solve(MatrixXd::Identity(n, n))));
    posterior.mean += weight * mean;
    posterior.covariance += weight * (root * root.transpose() + mean * mean.transpose());
    posterior.scale += weight * std::exp(logs[k]);
    share += weight;
    const auto until = std::min<Index>(kDraws, std::lround(share * kDraws));
    for (; drawn < until; ++drawn) {
      VectorXd unit(n);
      for (double& value : unit) value = Normal(random);
      posterior.draws.col(drawn) = mean + root * unit;
    }
  }
  posterior.covariance -= posterior.mean * posterior.mean.transpose();
  return posterior;
}

}  // namespace

SwayPosterior::Place SwayPosterior::At(double time_s) const { return PlaceIn(times, time_s); }

SwayMotion SwayPosterior::MeanAt(double time_s) const {
  const Place place = At(time_s);
  const auto n = static_cast<Index>(times.size());
  const auto at = [&](Index axis) {
    const Index k = axis * n + static_cast<Index>(place.knot);
    return mean[k] + place.share * (mean[k + 1] - mean[k]);
  };
  return {at(0), at(1), at(2)};
}

SwayPosterior SolveSway(const SwayEvidence& evidence, const SwayPrior& prior) {
  const std::vector<double> knots = KnotsOf(evidence.begin_s, evidence.end_s);
  const Whitened whitened = Whiten(Elimination(evidence, knots).Finish(), knots, prior);
  const std::vector<double> logs = LogScales(-4.0, 2.0, 0.25);
  // The yaw's scale: the likeliest, for the likeliest scale of the person by x and y with a typical yaw.
  std::vector<double> evidences(logs.size());
  const auto likeliest = [&](double yaw_scale) {
    for (std::size_t k = 0; k < logs.size(); ++k) {
      evidences[k] =
          SolveFor(whitened, std::exp(logs[k]), yaw_scale).log_evidence + LogPrior(logs[k], prior.scale_spread);
    }
    return logs[static_cast<std::size_t>(std::max_element(evidences.begin(), evidences.end()) - evidences.begin())];
  };
  const double person = std::exp(likeliest(1.0));
  double yaw_scale = 1.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const double logarithm : LogScales(-3.5, 2.0, 0.5)) {
    const double value = SolveFor(whitened, person, std::exp(logarithm)).log_evidence +
                         LogPrior(logarithm, prior.yaw_spread);
    if (value > best) {
      best = value;
      yaw_scale = std::exp(logarithm);
    }
  }
  likeliest(yaw_scale);
  const double most = *std::max_element(evidences.begin(), evidences.end());
  std::vector<double> weights;
  double total = 0.0;
  for (const double value : evidences) {
    weights.push_back(std::exp(value - most));
    total += weights.back();
  }
  for (double& weight : weights) weight /= total;
  SwayPosterior posterior = Mix(whitened, logs, weights, yaw_scale);
  posterior.times = knots;
  return posterior;
}

}  // namespace annulus
