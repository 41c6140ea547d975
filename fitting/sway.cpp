#include "fitting/sway.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "base/ensure.h"
#include "base/frames.h"
#include "fitting/sway_errors.h"
#include "fitting/sway_levels.h"
#include "fitting/sweep_paths.h"

namespace annulus {
namespace {

using Eigen::Index;

std::size_t ColumnsOf(std::span<const SurfaceSample> samples) {
  constexpr std::size_t kFewest = 24;
  constexpr std::size_t kMost = 360;
  std::set<std::uint16_t> sensors;
  for (const SurfaceSample& sample : samples) sensors.insert(sample.sensor);
  return std::clamp(sensors.size(), kFewest, kMost);
}

/// Distance between two levels of one sweep, mm: the median over all, the largest of all sweeps.
double SweepPitch(const std::vector<SweptLevel>& levels) {
  std::map<std::uint16_t, std::vector<double>> heights;
  for (const SweptLevel& level : levels) heights[level.sweep].push_back(level.z);
  double pitch = 0.0;
  for (auto& [sweep, z] : heights) {
    std::sort(z.begin(), z.end());
    std::vector<double> gaps;
    for (std::size_t k = 1; k < z.size(); ++k) gaps.push_back(z[k] - z[k - 1]);
    if (gaps.empty()) continue;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    pitch = std::max(pitch, gaps[gaps.size() / 2]);
  }
  return pitch;
}

/// A level's evidence about its whole motion, with what two levels may differ by beside sway (skin, clothes, the
/// surface between the levels) as further noise.
LevelEvidence EvidenceOf(const SweptLevel& level, const LevelMotion& seen, const SwayMotion& moved) {
  constexpr double kShift = 0.15;  // mm
  constexpr double kTurn = 0.002;  // rad
  LevelEvidence evidence{level.time_s, level.z, {}, {}};
  Eigen::Matrix<double, kSwayAxes, 3> noise = Eigen::Matrix<double, kSwayAxes, 3>::Zero();
  noise(3, 0) = noise(4, 1) = kShift;
  noise(2, 2) = kTurn;
  // (information⁻¹ + noise·noiseᵀ)⁻¹ of what may be singular.
  const Eigen::Matrix<double, kSwayAxes, 3> seen_noise = seen.information * noise;
  const Eigen::Matrix3d inner = Eigen::Matrix3d::Identity() + noise.transpose() * seen_noise;
  const SwayMatrix share = SwayMatrix::Identity() - seen_noise * inner.inverse() * noise.transpose();
  evidence.information = share * seen.information;
  evidence.information = 0.5 * (evidence.information + evidence.information.transpose()).eval();
  evidence.right = share * seen.right + evidence.information * moved.Vector();
  return evidence;
}

/// What a fixed sensor's reading says, given how far its point was moved back.
std::optional<RangeEvidence> EvidenceOf(const ReferenceReading& reading, const SwaySurface& surface,
                                        const SwayMotion& moved, double sigma) {
  constexpr double kFarthest = 30.0;  // mm: another surface, or somebody in the way
  if (!std::isfinite(reading.range) || !(reading.range > 0.0)) return std::nullopt;
  const Eigen::Vector3d p = RestFromStation(reading.origin + reading.range * reading.direction, moved);
  const double theta = WrapAngle(std::atan2(p.y(), p.x()));
  const auto place = surface.Between(theta, p.z());
  if (!place) return std::nullopt;
  const double miss = p.head<2>().norm() - place->r;
  if (std::abs(miss) > kFarthest) return std::nullopt;
  RangeEvidence evidence;
  evidence.time_s = reading.time_s;
  evidence.z = p.z();
  evidence.by = RadiusByMotion(*place, theta, p.z());
  evidence.miss = miss + evidence.by.dot(moved.Vector());
  // Along the ray to along the radius.
  const Eigen::Vector3d across(std::cos(theta) + place->r_theta / place->r * std::sin(theta),
                               std::sin(theta) - place->r_theta / place->r * std::cos(theta), -place->r_z);
  evidence.sigma = sigma * std::max(0.2, std::abs(across.dot(reading.direction)));
  evidence.sensor = reading.sensor;
  return evidence;
}

/// sd of one reading when readings of a fixed sensor that follow each other within a quarter of a second have an error
/// in common: of the surface where they look, and of its slope.
double ReferenceSigma(std::span<const ReferenceReading> references, double noise) {
  constexpr double kCommon = 0.2;                        // mm
  constexpr double kTogether = 0.25;                     // s
  std::map<std::uint16_t, std::array<double, 3>> spans;  // first and last time, number
  for (const ReferenceReading& reading : references) {
    auto& [first, last, count] = spans.try_emplace(reading.sensor, std::array{1e300, -1e300, 0.0}).first->second;
    first = std::min(first, reading.time_s);
    last = std::max(last, reading.time_s);
    count += 1.0;
  }
  double together = 1.0;
  for (const auto& [sensor, span] : spans) {
    if (span[1] > span[0]) together = std::max(together, span[2] * kTogether / (span[1] - span[0]));
  }
  return std::hypot(noise, kCommon * std::sqrt(together));
}

void Align(std::span<const SurfaceSample> samples, std::span<const ReferenceReading> references,
           const SwayOptions& options, SwayAlignment& alignment) {
  const std::size_t columns = ColumnsOf(samples);
  const double pitch = SweepPitch(alignment.levels);
  const auto moved_at = [&](double time_s) {
    return alignment.posterior.times.empty() ? SwayMotion{} : alignment.posterior.MeanAt(time_s);
  };
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<LevelCurve> curves;
    curves.reserve(alignment.levels.size());
    for (std::size_t k = 0; k < alignment.levels.size(); ++k) {
      curves.push_back(CurveOf(samples, alignment.levels[k], alignment.moved[k], columns));
    }
    const SwaySurface surface(curves, std::max(15.0, 1.6 * pitch));
    SwayEvidence evidence;
    evidence.begin_s = alignment.levels.front().time_s;
    evidence.end_s = alignment.levels.back().time_s;
    evidence.shape_step = std::clamp(pitch, 5.0, 40.0);
    alignment.compared = 0;
    for (std::size_t k = 0; k < curves.size() && alignment.sweeps > 1; ++k) {  // one sweep has nothing to compare with
      const LevelMotion seen = ObserveLevel(curves[k], surface);
      if (seen.information.isZero(0.0)) continue;
      ++alignment.compared;
      evidence.levels.push_back(EvidenceOf(alignment.levels[k], seen, alignment.moved[k]));
    }
    const double sigma = ReferenceSigma(references, options.reference_sigma_mm);
    for (const ReferenceReading& reading : references) {
      const auto range = EvidenceOf(reading, surface, moved_at(reading.time_s), sigma);
      if (range) evidence.ranges.push_back(*range);
    }
    alignment.references = evidence.ranges.size();
    const bool is_last = round + 1 == options.rounds;
    alignment.posterior = SolveSway(evidence, options.prior, is_last ? SwayDetail::kAll : SwayDetail::kMean);
    for (std::size_t k = 0; k < alignment.levels.size(); ++k) {
      alignment.moved[k] = alignment.posterior.MeanAt(alignment.levels[k].time_s);
    }
  }
}

/// Takes from each level's motion the mean of all sweeps at its height.
void LeaveCommonPart(SwayAlignment& alignment) {
  const SweepPaths paths(alignment.levels);
  std::vector<SwayVector> common;
  for (const SweptLevel& level : alignment.levels) {
    const std::vector<double> times = paths.NearestTimes(level.z);
    SwayVector sum = SwayVector::Zero();
    for (const double time : times) sum += alignment.posterior.MeanAt(time).Vector();
    common.push_back(sum / static_cast<double>(times.size()));
  }
  for (std::size_t k = 0; k < common.size(); ++k) {
    const SwayVector rest = alignment.moved[k].Vector() - common[k];
    alignment.moved[k] = {rest[0], rest[1], rest[2], rest[3], rest[4]};
  }
}

void MoveBack(const SwayAlignment& alignment, std::vector<SurfaceSample>& samples) {
  for (std::size_t k = 0; k < alignment.levels.size(); ++k) {
    for (const std::size_t index : alignment.levels[k].samples) {
      SurfaceSample& sample = samples[index];
      const Eigen::Vector3d p = RestFromStation(sample.Point(), alignment.moved[k]);
      sample.theta = WrapAngle(std::atan2(p.y(), p.x()));
      sample.z = p.z();
      sample.radius = p.head<2>().norm();
    }
  }
}

/// What is within the noise of the comparison is no motion: the samples stay what they were, to the bit.
void LeaveAlone(SwayEstimate& estimate) {
  estimate.errors.reset();
  estimate.summary.removed_mm = 0.0;
  estimate.reason = "less than the comparison can tell";
  for (SwayLevel& level : estimate.levels) level.motion = {};
}

}  // namespace

SwayEstimate EstimateSway(std::span<const SurfaceSample> samples, std::span<const ReferenceReading> references,
                          const SwayOptions& options) {
  constexpr std::size_t kFewestLevels = 10;
  constexpr double kLeastSway = 0.15;  // mm
  SwayEstimate estimate;
  SwayAlignment alignment;
  alignment.levels = LevelsOf(samples);
  alignment.moved.resize(alignment.levels.size());
  estimate.corrected.assign(samples.begin(), samples.end());
  if (alignment.levels.size() < kFewestLevels || !(alignment.levels.back().time_s > alignment.levels.front().time_s)) {
    estimate.reason = alignment.levels.size() < kFewestLevels ? "too few levels" : "the samples have no times";
    return estimate;
  }
  std::set<std::uint16_t> sweeps;
  for (const SweptLevel& level : alignment.levels) sweeps.insert(level.sweep);
  alignment.sweeps = sweeps.size();
  Align(samples, references, options, alignment);
  estimate.summary.sweeps = alignment.sweeps;
  estimate.summary.levels = alignment.compared;
  estimate.summary.references = alignment.references;
  const bool seen = alignment.references > 0 || (alignment.sweeps > 1 && alignment.compared >= kFewestLevels);
  estimate.view = seen ? SwayView::kSeen : SwayView::kNotSeen;
  if (!seen) estimate.reason = alignment.sweeps > 1 ? "sweeps without heights in common" : "one sweep shows no sway";
  alignment.common = alignment.references > 0 ? CommonPart::kTakenOut : CommonPart::kLeft;
  if (!seen) {
    alignment.moved.assign(alignment.levels.size(), SwayMotion{});
  } else if (alignment.common == CommonPart::kLeft) {
    LeaveCommonPart(alignment);
  }
  FillSway(alignment, estimate);
  if (!seen) return estimate;
  if (estimate.summary.removed_mm < kLeastSway) {
    LeaveAlone(estimate);
  } else {
    MoveBack(alignment, estimate.corrected);
  }
  return estimate;
}

std::string SwayEstimate::BriefReport() const {
  std::array<char, 256> line{};
  const SwaySummary& s = summary;
  switch (view) {
    case SwayView::kUnknown:
      return "sway: unknown, " + reason;
    case SwayView::kNotSeen:
      std::snprintf(line.data(), line.size(), "sway: not seen, %s; people sway %.1f mm sideways, %.1f front-back (sd)",
                    reason.c_str(), s.sd_x.value, s.sd_y.value);
      break;
    case SwayView::kSeen:
      std::snprintf(line.data(), line.size(),
                    "sway: sd %.2f ± %.2f mm sideways, %.2f ± %.2f front-back at 1 m, yaw %.2f deg; %.2f mm removed, "
                    "%.2f remain",
                    s.sd_x.value, s.sd_x.sigma, s.sd_y.value, s.sd_y.sigma, DegreesFromRadians(s.sd_yaw.value),
                    s.removed_mm, s.remaining_mm);
      break;
  }
  return line.data();
}

}  // namespace annulus
