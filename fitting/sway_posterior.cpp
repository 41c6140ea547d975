#include "fitting/sway_posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>

#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kKnotStep = 0.3;  // s: a quarter of the fast scale
constexpr std::size_t kMostKnots = 200;
constexpr std::size_t kMostHeights = 200;
constexpr int kDraws = 200;
// The shape of a body at a height is any place and direction: as lean and yaw move it.
constexpr Index kShapeAxes = 3;

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
    const Index n = kSwayAxes * Count(knots_);
    const Index m = kShapeAxes * Count(heights_) + static_cast<Index>(sensors_);
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
    const Index shapes = kShapeAxes * Count(heights_);
    for (Index k = 0; k < cc_.rows(); ++k) {
      const double sd = k >= shapes ? kOffset : k % kShapeAxes == 2 ? 1e-3 * kShape : kShape;
      cc_(k, k) += 1.0 / (sd * sd);
    }
    const Eigen::LLT<MatrixXd> factor(cc_);
    const MatrixXd half = factor.matrixL().solve(sc_.transpose());
    return {ss_ - half.transpose() * half, s_ - half.transpose() * factor.matrixL().solve(c_)};
  }

 private:
  static Index Count(const std::vector<double>& values) { return static_cast<Index>(values.size()); }
  /// One linear combination of unknowns, as index and factor.
  struct Term {
    Index index;
    double factor;
  };
  using Pair = std::array<Term, 2>;
  [[nodiscard]] Pair MotionTerms(double time_s, Index axis) const {
    const auto place = PlaceIn(knots_, time_s);
    const Index first = axis * Count(knots_) + static_cast<Index>(place.knot);
    return {Term{first, 1.0 - place.share}, Term{first + 1, place.share}};
  }
  [[nodiscard]] Pair ShapeTerms(double z, Index axis) const {
    const auto place = PlaceIn(heights_, z);
    const Index first = kShapeAxes * static_cast<Index>(place.knot) + axis;
    return {Term{first, 1.0 - place.share}, Term{first + kShapeAxes, place.share}};
  }

  void Add(const LevelEvidence& level) {
    for (Index a = 0; a < kSwayAxes; ++a) {
      const Pair motion = MotionTerms(level.time_s, a);
      for (const Term& term : motion) s_[term.index] += term.factor * level.right[a];
      for (Index b = 0; b < kSwayAxes; ++b) {
        AddProduct(ss_, motion, MotionTerms(level.time_s, b), level.information(a, b));
      }
      for (Index b = 0; b < kShapeAxes; ++b) {
        AddProduct(sc_, motion, ShapeTerms(level.z, b), level.information(a, b));
      }
    }
    for (Index a = 0; a < kShapeAxes; ++a) {
      const Pair shape = ShapeTerms(level.z, a);
      for (const Term& term : shape) c_[term.index] += term.factor * level.right[a];
      for (Index b = 0; b < kShapeAxes; ++b) {
        AddProduct(cc_, shape, ShapeTerms(level.z, b), level.information(a, b));
      }
    }
  }

  static void AddProduct(MatrixXd& matrix, std::span<const Term> rows, std::span<const Term> columns, double weight) {
    for (const Term& row : rows) {
      for (const Term& column : columns) matrix(row.index, column.index) += row.factor * column.factor * weight;
    }
  }

  void Add(const RangeEvidence& range) {
    const double weight = 1.0 / (range.sigma * range.sigma);
    std::vector<Term> motion;
    std::vector<Term> rest{{kShapeAxes * Count(heights_) + static_cast<Index>(range.sensor), 1.0}};
    for (Index a = 0; a < kSwayAxes; ++a) {
      for (const Term& term : MotionTerms(range.time_s, a)) motion.push_back({term.index, range.by[a] * term.factor});
    }
    for (Index a = 0; a < kShapeAxes; ++a) {
      for (const Term& term : ShapeTerms(range.z, a)) rest.push_back({term.index, range.by[a] * term.factor});
    }
    for (const Term& term : motion) s_[term.index] += weight * term.factor * range.miss;
    for (const Term& term : rest) c_[term.index] += weight * term.factor * range.miss;
    AddProduct(ss_, motion, motion, weight);
    AddProduct(sc_, motion, rest, weight);
    AddProduct(cc_, rest, rest, weight);
  }

  std::vector<double> knots_;
  std::vector<double> heights_;
  std::size_t sensors_ = 0;
  MatrixXd ss_, sc_, cc_;
  VectorXd s_, c_;
};

/// How large a person's sway is against a typical one's.
struct Scales {
  double person = 1.0;
  double yaw = 1.0;    ///< Further scale of the yaw,
  double shift = 1.0;  ///< and of the shift.
};

/// The evidence in units of the prior of a typical person: motion = root · unit motion, unit motion ~ N(0, scale²).
struct Whitened {
  MatrixXd root;         ///< Of the covariance of the typical lean_x over time, lower triangle.
  MatrixXd information;  ///< kSwayAxes·n × kSwayAxes·n
  VectorXd right;

  /// By axis.
  [[nodiscard]] VectorXd Repeat(const SwayVector& scales) const {
    const Index n = root.rows();
    VectorXd d(kSwayAxes * n);
    for (Index a = 0; a < kSwayAxes; ++a) d.segment(a * n, n).setConstant(scales[a]);
    return d;
  }
  [[nodiscard]] MatrixXd Coloured(const MatrixXd& unit) const {
    const Index n = root.rows();
    MatrixXd result(unit.rows(), unit.cols());
    for (Index a = 0; a < kSwayAxes; ++a) {
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
  w.information.resize(kSwayAxes * n, kSwayAxes * n);
  w.right.resize(kSwayAxes * n);
  for (Index a = 0; a < kSwayAxes; ++a) {
    w.right.segment(a * n, n) = w.root.transpose() * reduced.right.segment(a * n, n);
    for (Index b = 0; b < kSwayAxes; ++b) {
      w.information.block(a * n, b * n, n, n) =
          w.root.transpose() * reduced.information.block(a * n, b * n, n, n) * w.root;
    }
  }
  return w;
}

/// The posterior for given scales.
struct Solved {
  VectorXd scales;
  Eigen::LLT<MatrixXd> factor;  ///< Of I + D·information·D.
  VectorXd unit_mean;
  double log_evidence = 0.0;
};

/// Finds the likeliest scales and mixes over the person's.
class ScaleSearch {
 public:
  ScaleSearch(const Whitened& whitened, const SwayPrior& prior) : w_(whitened), prior_(prior) {}

  [[nodiscard]] Solved Solve(const Scales& scales) const {
    Solved s;
    const double x = scales.person;
    const double y = scales.person * prior_.forward;
    const double shift = scales.shift * prior_.shift;
    s.scales = w_.Repeat({x, y, x * scales.yaw * prior_.yaw, x * shift, y * shift});
    MatrixXd b = s.scales.asDiagonal() * w_.information * s.scales.asDiagonal();
    b.diagonal().array() += 1.0;
    s.factor.compute(b);
    const VectorXd right = s.scales.cwiseProduct(w_.right);
    s.unit_mean = s.factor.solve(right);
    s.log_evidence = 0.5 * right.dot(s.unit_mean) - s.factor.matrixLLT().diagonal().array().log().sum();
    return s;
  }

  /// The likeliest of some values of one of the scales, the others given.
  [[nodiscard]] Scales Likeliest(const Scales& others, double Scales::*which, std::span<const double> logs) const {
    const double spread = which == &Scales::person ? prior_.scale_spread : prior_.further_spread;
    Scales best = others;
    double most = -std::numeric_limits<double>::infinity();
    for (const double logarithm : logs) {
      Scales scales = others;
      scales.*which = std::exp(logarithm);
      const double value = Solve(scales).log_evidence + LogPrior(logarithm, spread);
      if (value > most) {
        most = value;
        best = scales;
      }
    }
    return best;
  }

  /// The posteriors of all scales of the person about the likeliest, mixed.
  [[nodiscard]] SwayPosterior Mix(const Scales& likeliest) const {
    std::vector<Solved> solved;
    std::vector<double> logs;
    std::vector<double> values;
    for (int k = -6; k <= 6; ++k) {
      Scales scales = likeliest;
      logs.push_back(std::log(likeliest.person) + 0.2 * k);
      scales.person = std::exp(logs.back());
      solved.push_back(Solve(scales));
      values.push_back(solved.back().log_evidence + LogPrior(logs.back(), prior_.scale_spread));
    }
    const double most = *std::max_element(values.begin(), values.end());
    double total = 0.0;
    for (double& value : values) {
      value = std::exp(value - most);
      if (value < kLeast) value = 0.0;
      total += value;
    }
    for (double& value : values) value /= total;
    SwayPosterior posterior = Mixed(solved, values);
    posterior.scale = 0.0;
    for (std::size_t k = 0; k < logs.size(); ++k) posterior.scale += values[k] * std::exp(logs[k]);
    return posterior;
  }

  [[nodiscard]] VectorXd Mean(const Solved& solved) const {
    return w_.Coloured(solved.scales.cwiseProduct(solved.unit_mean));
  }

 private:
  static constexpr double kLeast = 0.01;  // of the largest weight: the rest changes nothing

  static double LogPrior(double logarithm, double spread) { return -0.5 * logarithm * logarithm / (spread * spread); }

  [[nodiscard]] SwayPosterior Mixed(const std::vector<Solved>& solved, const std::vector<double>& weights) const {
    const Index n = w_.information.rows();
    SwayPosterior posterior;
    posterior.mean = VectorXd::Zero(n);
    posterior.covariance = MatrixXd::Zero(n, n);
    posterior.draws.resize(n, kDraws);
    std::mt19937_64 random(1);
    double share = 0.0;
    Index drawn = 0;
    for (std::size_t k = 0; k < solved.size(); ++k) {
      if (weights[k] == 0.0) continue;
      const VectorXd mean = Mean(solved[k]);
      const MatrixXd inverse = solved[k].factor.matrixU().solve(MatrixXd::Identity(n, n));
      const MatrixXd root = w_.Coloured(solved[k].scales.asDiagonal() * inverse);
      posterior.mean += weights[k] * mean;
      posterior.covariance += weights[k] * (root * root.transpose() + mean * mean.transpose());
      share += weights[k];
      const Index until = std::min<Index>(kDraws, std::lround(share * kDraws));
      MatrixXd units(n, std::max<Index>(0, until - drawn));
      for (Index column = 0; column < units.cols(); ++column) {
        for (Index row = 0; row < n; ++row) units(row, column) = Normal(random);
      }
      posterior.draws.middleCols(drawn, units.cols()) = (root * units).colwise() + mean;
      drawn += units.cols();
    }
    posterior.covariance -= posterior.mean * posterior.mean.transpose();
    return posterior;
  }

  /// Standard normal by Box and Muller.
  static double Normal(std::mt19937_64& random) {
    const auto uniform = [&] { return (static_cast<double>(random() >> 11U) + 0.5) * 0x1p-53; };
    const double u = uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * uniform());
  }

  const Whitened& w_;
  const SwayPrior& prior_;
};

std::vector<double> LogScales(double low, double high, double step) {
  std::vector<double> values;
  for (double value = low; value <= high + 1e-9; value += step) values.push_back(value);
  return values;
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
  return {at(0), at(1), at(2), at(3), at(4)};
}

SwayPosterior SolveSway(const SwayEvidence& evidence, const SwayPrior& prior, SwayDetail detail) {
  const std::vector<double> knots = KnotsOf(evidence.begin_s, evidence.end_s);
  const Whitened whitened = Whiten(Elimination(evidence, knots).Finish(), knots, prior);
  const ScaleSearch search(whitened, prior);
  Scales scales = search.Likeliest({}, &Scales::person, LogScales(-4.0, 2.0, 0.75));
  SwayPosterior posterior;
  if (detail == SwayDetail::kMean) {
    posterior.mean = search.Mean(search.Solve(scales));
  } else {
    scales = search.Likeliest(scales, &Scales::shift, LogScales(-3.0, 3.0, 1.0));
    scales = search.Likeliest(scales, &Scales::yaw, LogScales(-3.0, 2.0, 1.0));
    const double about = std::log(scales.person);
    scales = search.Likeliest(scales, &Scales::person, LogScales(about - 1.0, about + 1.0, 0.25));
    posterior = search.Mix(scales);
    posterior.yaw_scale = scales.yaw;
    posterior.shift_scale = scales.shift;
  }
  posterior.times = knots;
  return posterior;
}

}  // namespace annulus
