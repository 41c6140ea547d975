#include "fitting/sway.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/ensure.h"
#include "base/frames.h"
#include "fitting/sway_errors.h"
#include "fitting/sway_levels.h"

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
double SweepPitch(const std::vector<RingLevel>& levels) {
  std::map<std::uint16_t, std::vector<double>> heights;
  for (const RingLevel& level : levels) heights[level.sweep].push_back(level.z);
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
LevelEvidence EvidenceOf(const RingLevel& level, const LevelMotion& seen, const SwayMotion& moved) {
  constexpr double kShift = 0.15;  // mm
  constexpr double kTurn = 0.002;  // rad
  constexpr double kLowest = 50.0;  // mm
  LevelEvidence evidence{level.time_s, level.z, {}, {}};
  const double lean = std::max(kLowest, level.z) / kSwayHeight;
  const Eigen::Vector3d noise(kShift / lean, kShift / lean, kTurn);
  Eigen::Matrix3d sum = seen.information;
  sum.diagonal() += noise.array().square().inverse().matrix();
  const Eigen::Matrix3d share = Eigen::Matrix3d::Identity() - seen.information * sum.inverse();
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
  evidence.by = RadiusByMotion(*place, theta, p.z());
  evidence.miss = miss + evidence.by.dot(moved.Vector());
  // Along the ray to along the radius.
  const Eigen::Vector3d across(std::cos(theta) + place->r_theta / place->r * std::sin(theta),
                               std::sin(theta) - place->r_theta / place->r * std::cos(theta), -place->r_z);
  evidence.sigma = sigma * std::max(0.2, std::abs(across.dot(reading.direction)));
  evidence.sensor = reading.sensor;
  return evidence;
}

/// The scan and what is known of its motion so far.
struct Alignment {
  std::vector<RingLevel> levels;
  std::vector<SwayMotion> moved;  ///< By level.
  SwayPosterior posterior;
  std::size_t compared = 0;
  std::size_t references = 0;
};

void Align(std::span<const SurfaceSample> samples, std::span<const ReferenceReading> references,
           const SwayOptions& options, Alignment& alignment) {
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
    for (std::size_t k = 0; k < curves.size(); ++k) {
      const LevelMotion seen = ObserveLevel(curves[k], surface);
      if (seen.information.isZero(0.0)) continue;
      ++alignment.compared;
      evidence.levels.push_back(EvidenceOf(alignment.levels[k], seen, alignment.moved[k]));
    }
    for (const ReferenceReading& reading : references) {
      const auto range =
          EvidenceOf(reading, surface, moved_at(reading.time_s), options.reference_sigma_mm);
      if (range) evidence.ranges.push_back(*range);
    }
    alignment.references = evidence.ranges.size();
    alignment.posterior = SolveSway(evidence, options.prior);
    for (std::size_t k = 0; k < alignment.levels.size(); ++k) {
      alignment.moved[k] = alignment.posterior.MeanAt(alignment.levels[k].time_s);
    }
  }
}

std::vector<SurfaceSample> MovedBack(std::span<const SurfaceSample> samples, const SwayPosterior& posterior) {
  std::vector<SurfaceSample> moved(samples.begin(), samples.end());
  for (SurfaceSample& sample : moved) {
    const Eigen::Vector3d p = RestFromStation(sample.Point(), posterior.MeanAt(sample.time_s));
    sample.theta = WrapAngle(std::atan2(p.y(), p.x()));
    sample.z = p.z();
    sample.radius = p.head<2>().norm();
  }
  return moved;
}

}  // namespace

SwayEstimate EstimateSway(std::span<const SurfaceSample> samples, std::span<const ReferenceReading> references,
                          const SwayOptions& options) {
  constexpr std::size_t kFewestLevels = 10;
  SwayEstimate estimate;
  Alignment alignment;
  alignment.levels = LevelsOf(samples);
  alignment.moved.resize(alignment.levels.size());
  estimate.corrected.assign(samples.begin(), samples.end());
  if (alignment.levels.size() < kFewestLevels ||
      !(alignment.levels.back().time_s > alignment.levels.front().time_s)) {
    estimate.reason = alignment.levels.size() < kFewestLevels ? "too few levels" : "the samples have no times";
    return estimate;
  }
  Align(samples, references, options, alignment);
  std::set<std::uint16_t> sweeps;
  for (const RingLevel& level : alignment.levels) sweeps.insert(level.sweep);
  estimate.summary.sweeps = sweeps.size();
  estimate.summary.levels = alignment.compared;
  estimate.summary.references = alignment.references;
  const bool seen = alignment.references > 0 || sweeps.size() > 1;
  estimate.view = seen ? SwayView::kSeen : SwayView::kNotSeen;
  if (!seen) estimate.reason = "one sweep shows no sway";
  if (seen) estimate.corrected = MovedBack(samples, alignment.posterior);
  FillSway(alignment.levels, alignment.posterior, estimate);
  return estimate;
}

}  // namespace annulus
