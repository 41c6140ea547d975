#include "fitting/paper_features.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>

namespace annulus {
namespace {

constexpr std::size_t kFewestInWindow = 7;
constexpr auto kHalf = static_cast<std::ptrdiff_t>(kLocalCubicHalfWidth);

/// Index of the sample `offset` after `k`, and what must be added to its x; none beyond the end of an open curve.
struct Neighbour {
  bool exists = false;
  std::size_t index = 0;
  double turn = 0.0;
};

Neighbour NeighbourOf(const CurveSamples& samples, std::size_t k, std::ptrdiff_t offset) {
  const auto n = static_cast<std::ptrdiff_t>(samples.size());
  std::ptrdiff_t at = static_cast<std::ptrdiff_t>(k) + offset;
  if (at >= 0 && at < n) return {true, static_cast<std::size_t>(at), 0.0};
  if (!samples.closed() || 2 * kHalf >= n) return {};
  const double turn = at < 0 ? -samples.period : samples.period;
  return {true, static_cast<std::size_t>((at + n) % n), turn};
}

/// Eq. 2.5 about sample k: c0 … c3 in offsets scaled by the window's reach, so that the equations are well scaled.
SlopeEstimate EstimateAt(const CurveSamples& samples, std::size_t k) {
  std::array<double, 2 * kLocalCubicHalfWidth + 1> offsets{};
  std::array<double, 2 * kLocalCubicHalfWidth + 1> values{};
  std::array<double, 2 * kLocalCubicHalfWidth + 1> weights{};
  std::size_t count = 0;
  std::size_t before = 0;
  std::size_t after = 0;
  double reach = 0.0;
  for (std::ptrdiff_t j = -kHalf; j <= kHalf; ++j) {
    const Neighbour other = NeighbourOf(samples, k, j);
    if (!other.exists || samples.weight[other.index] <= 0.0) continue;
    offsets[count] = samples.x[other.index] + other.turn - samples.x[k];
    values[count] = samples.value[other.index];
    weights[count] = samples.weight[other.index];
    reach = std::max(reach, std::abs(offsets[count]));
    before += j < 0 ? 1 : 0;
    after += j > 0 ? 1 : 0;
    ++count;
  }
  SlopeEstimate estimate;
  if (count < kFewestInWindow || before < 2 || after < 2 || reach <= 0.0) return estimate;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d noise = Eigen::Matrix4d::Zero();  // Σ w² aaᵀ: the samples' noise is the same whatever their weight
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t j = 0; j < count; ++j) {
    const double t = offsets[j] / reach;
    const Eigen::Vector4d a(1.0, t, t * t, t * t * t);
    normal += weights[j] * a * a.transpose();
    noise += weights[j] * weights[j] * a * a.transpose();
    right += weights[j] * values[j] * a;
  }
  const Eigen::Matrix4d inverse = normal.ldlt().solve(Eigen::Matrix4d::Identity());
  const Eigen::Vector4d c = inverse * right;
  const Eigen::Matrix4d covariance = inverse * noise * inverse;
  if (!c.allFinite() || !covariance.allFinite()) return estimate;
  return {true, c[1] / reach, 2.0 * c[2] / (reach * reach), std::sqrt(std::max(0.0, covariance(1, 1))) / reach,
          2.0 * std::sqrt(std::max(0.0, covariance(2, 2))) / (reach * reach)};
}

/// One of the two estimates over its sd, per sample; 0 where unknown.
std::vector<double> Standardised(const std::vector<SlopeEstimate>& slopes, FeatureKind kind, double noise_sd) {
  std::vector<double> standardised;
  for (const SlopeEstimate& slope : slopes) {
    const double value = kind == FeatureKind::kExtremum ? slope.first : slope.second;
    const double sd = noise_sd * (kind == FeatureKind::kExtremum ? slope.first_gain : slope.second_gain);
    standardised.push_back(slope.known && sd > 0.0 ? value / sd : 0.0);
  }
  return standardised;
}

/// A sign change between samples that are sure of their sign: the sample before it and the lower of the two peaks.
struct SignChange {
  std::size_t sample = 0;
  double significance = 0.0;
};

/// The flip between two sure samples of opposite sign that leaves least on the wrong side. No value where the flip
/// falls into a hole.
std::vector<SignChange> BestFlip(const std::vector<double>& e, std::size_t from, std::size_t to) {
  const std::size_t n = e.size();
  const double sign = e[from] > 0.0 ? 1.0 : -1.0;
  const std::size_t length = (to + n - from) % n;
  double right_side = 0.0;
  double best = -1.0;
  std::size_t flip = from;
  for (std::size_t j = 0; j < length; ++j) {
    const double here = sign * e[(from + j) % n];
    right_side += here;
    if (here > 0.0 && sign * e[(from + j + 1) % n] <= 0.0 && right_side > best) {
      best = right_side;
      flip = (from + j) % n;
    }
  }
  if (best < 0.0 || e[(flip + 1) % n] == 0.0) return {};
  return {{flip, 0.0}};
}

std::vector<SignChange> SignChanges(const std::vector<double>& e, double gate, bool closed) {
  std::vector<std::size_t> sure;
  for (std::size_t k = 0; k < e.size(); ++k) {
    if (std::abs(e[k]) > gate) sure.push_back(k);
  }
  // Runs of one sign, with their peaks.
  struct Run {
    std::size_t first;
    std::size_t last;
    double peak;
  };
  std::vector<Run> runs;
  for (const std::size_t k : sure) {
    if (runs.empty() || e[runs.back().last] * e[k] < 0.0) runs.push_back({k, k, 0.0});
    runs.back().last = k;
    runs.back().peak = std::max(runs.back().peak, std::abs(e[k]));
  }
  if (closed && runs.size() > 1 && e[runs.back().last] * e[runs.front().first] > 0.0) {
    runs.front().first = runs.back().first;  // one run over the seam
    runs.front().peak = std::max(runs.front().peak, runs.back().peak);
    runs.pop_back();
  }
  std::vector<SignChange> changes;
  const std::size_t pairs = closed ? runs.size() : std::max<std::size_t>(runs.size(), 1) - 1;
  for (std::size_t k = 0; k < pairs && runs.size() > 1; ++k) {
    const Run& before = runs[k];
    const Run& after = runs[(k + 1) % runs.size()];
    for (SignChange change : BestFlip(e, before.last, after.first)) {
      change.significance = std::min(before.peak, after.peak);
      changes.push_back(change);
    }
  }
  return changes;
}

struct Candidate {
  std::size_t sample;
  FeaturePoint point;
};

/// Keeps the more significant of features that are too near to each other, strongest first.
std::vector<Candidate> ThinOut(std::vector<Candidate> candidates, const CurveSamples& samples) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.point.significance > b.point.significance; });
  const std::size_t n = samples.size();
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      const std::size_t apart = candidate.sample > other.sample ? candidate.sample - other.sample  //
                                                                : other.sample - candidate.sample;
      return std::min(apart, samples.closed() ? n - apart : apart) < kSamplesPerFeatureGap;
    });
    if (!near) kept.push_back(candidate);
  }
  std::sort(kept.begin(), kept.end(), [](const Candidate& a, const Candidate& b) { return a.sample < b.sample; });
  return kept;
}

}  // namespace

std::vector<SlopeEstimate> EstimateSlopes(const CurveSamples& samples) {
  std::vector<SlopeEstimate> slopes;
  slopes.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) slopes.push_back(EstimateAt(samples, k));
  return slopes;
}

double SignificanceGate(std::size_t samples) {
  constexpr double kFalseAlarm = 0.05;
  const double each = kFalseAlarm / static_cast<double>(std::max<std::size_t>(samples, 1));
  double low = 0.0;
  double high = 40.0;
  for (int k = 0; k < 80; ++k) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle / std::sqrt(2.0)) > each ? low : high) = middle;
  }
  return high;
}

std::vector<FeaturePoint> FindFeatures(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                                       double noise_sd) {
  const double gate = SignificanceGate(samples.size());
  std::vector<Candidate> candidates;
  for (const FeatureKind kind : {FeatureKind::kExtremum, FeatureKind::kInflection}) {
    const std::vector<double> e = Standardised(slopes, kind, noise_sd);
    for (const SignChange& change : SignChanges(e, gate, samples.closed())) {
      candidates.push_back({change.sample, {kind, samples.x[change.sample], change.significance}});
    }
  }
  std::vector<FeaturePoint> features;
  for (const Candidate& kept : ThinOut(std::move(candidates), samples)) features.push_back(kept.point);
  return features;
}

Complexity MeasureComplexity(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                             const std::vector<FeaturePoint>& features) {
  Complexity complexity{features.size(), 0.0};
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    if (!slopes[k].known || !slopes[k + 1].known) continue;
    complexity.bending +=
        0.5 * (std::abs(slopes[k].second) + std::abs(slopes[k + 1].second)) * (samples.x[k + 1] - samples.x[k]);
  }
  return complexity;
}

}  // namespace annulus
