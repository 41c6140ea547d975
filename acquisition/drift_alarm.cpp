#include "acquisition/drift_alarm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "acquisition/drift_pursuit.h"
#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kScanSigmaFactor =
    1.25;  // a scan's own sd is that much too small (tests/acquisition/drift_watch_test)

constexpr double kNoiseShare = 0.75;      // of a filtered offset's variance; the rest is the bodies'
constexpr double kTrendNoiseShare = 0.9;  // the body's shape cancels in trends

/// Variance of one scan's offset as an estimate of the sensor's, mm².
double VarianceOf(double sigma, const DriftRules& rules) {
  return kScanSigmaFactor * kScanSigmaFactor * sigma * sigma + rules.person_sigma_mm * rules.person_sigma_mm;
}

/// One sensor through all scans since the calibration.
class SensorFilter {
 public:
  explicit SensorFilter(const DriftRules& rules) : rules_(rules), variance_(Square(rules.body_sigma_mm)) {}

  void Add(double offset, double sigma) {
    if (!std::isfinite(offset) || !std::isfinite(sigma)) return;
    constexpr double kClip = 4.0;
    const double noise = VarianceOf(sigma, rules_);
    if (seen_ < rules_.baseline_scans) {
      precision_ += 1.0 / noise;
      sum_ += offset / noise;
    }
    ++seen_;
    const double predicted = variance_ + Square(rules_.wander_sigma_mm);
    const double whole = std::sqrt(predicted + noise);
    constexpr double kPriorScans = 10.0;
    constexpr double kLeast = 0.8;
    scatter_ = std::max(kLeast, (kPriorScans + surprises_) / (kPriorScans + static_cast<double>(seen_ - 1)));
    surprises_ += std::min(Square((offset - offset_) / whole), Square(kClip));
    offset_ += predicted / (predicted + noise) * std::clamp(offset - offset_, -kClip * whole, kClip * whole);
    variance_ = predicted * noise / (predicted + noise);
  }
  [[nodiscard]] SensorState state() const {
    SensorState state;
    if (seen_ == 0) return state;
    state.offset_mm = offset_;
    state.sigma_mm = std::sqrt(variance_);
    state.scatter = scatter_;
    if (seen_ < rules_.baseline_scans) return state;
    state.baseline_mm = sum_ / precision_;
    state.baseline_sigma_mm = 1.0 / std::sqrt(precision_);
    return state;
  }

 private:
  static double Square(double number) { return number * number; }

  const DriftRules& rules_;
  std::size_t seen_ = 0;
  double offset_ = 0.0;
  double variance_;
  double sum_ = 0.0, precision_ = 0.0;  ///< Of the baseline.
  double surprises_ = 0.0;              ///< Sum of squared innovations over their variances.
  double scatter_ = 1.0;
};

/// What makes an alarm of a fit.
struct Bar {
  DriftSince since = DriftSince::kBaseline;
  double limit_mm = 0.0;
  double significance = 0.0;
  double end_s = 0.0;  ///< The drift is judged this long after the middle of the scan.
};

/// One scan alone: the offset changes while it lasts, or is such that no body looks like that. Of a moderate offset
/// that stays the same, one customer may be the cause.
bool CreptOrJumped(const DriftPursuit::Fit& fit) {
  constexpr double kCreeps = 2.0;  // sd
  constexpr double kJumped = 8.0;
  const double trend = fit.size[1] / std::sqrt(fit.variance[1]);
  const double offset = fit.size[0] / std::sqrt(fit.variance[0]);
  return (trend * offset > 0.0 && std::abs(trend) >= kCreeps) || std::abs(offset) >= kJumped;
}

std::vector<DriftAlarm> FindAlarms(DriftPursuit pursuit, const Bar& bar) {
  constexpr std::size_t kMost = 40;  // a ring with more is not drifting but wrong
  constexpr double kBeside = 0.35;   // a neighbour must be that much of its own to be named beside one
  std::vector<DriftAlarm> alarms;
  std::vector<DriftPursuit::Fit> found;
  while (alarms.size() < kMost) {
    const DriftPursuit::Fit best = pursuit.Best();
    constexpr double kManyAtOnce = 1.2;  // what smooth errors of the prediction look like
    const double significance = best.block.count > 1 ? kManyAtOnce * bar.significance : bar.significance;
    if (!(std::sqrt(best.gain) >= significance)) break;
    const double drift = best.size[0] + bar.end_s * best.size[1];
    const bool beside = std::any_of(found.begin(), found.end(), [&](const DriftPursuit::Fit& old) {
      const double apart = std::abs(static_cast<double>(old.block.first) - static_cast<double>(best.block.first));
      const double old_drift = old.size[0] + bar.end_s * old.size[1];
      return apart <= static_cast<double>(kNeighbourReach) && std::abs(drift) < kBeside * std::abs(old_drift);
    });
    pursuit.Subtract(best);
    found.push_back(best);
    if (std::abs(drift) < bar.limit_mm || beside || (bar.end_s > 0.0 && !CreptOrJumped(best))) {
      if (found.size() > 2 * kMost) break;
      continue;
    }
    const double sigma =
        std::sqrt(best.variance[0] + bar.end_s * bar.end_s * (bar.end_s > 0.0 ? best.variance[1] : 0.0));
    alarms.push_back({best.block.first, best.block.count, bar.since, drift, sigma, best.size[1]});
  }
  return alarms;
}

/// The deviations from the baselines, or from zero.
DriftEvidence DeviationsFrom(DriftSince since, const std::vector<SensorState>& sensors, const DriftRules& rules) {
  DriftEvidence evidence;
  for (const SensorState& sensor : sensors) {
    const bool baseline = since == DriftSince::kBaseline;
    const double sigma = baseline ? sensor.baseline_sigma_mm : rules.body_sigma_mm;
    evidence.deviation.push_back(sensor.offset_mm - (baseline ? sensor.baseline_mm : 0.0));
    const double filtered = sensor.sigma_mm * sensor.sigma_mm;
    evidence.noise_variance.push_back(kNoiseShare * (filtered + (baseline ? sigma * sigma : 0.0)));
    evidence.own_variance.push_back((1.0 - kNoiseShare) * filtered +
                                    (baseline ? 1.0 - kNoiseShare : 1.0) * sigma * sigma);
  }
  return evidence;
}

/// Offset and trend of the newest scan.
std::vector<DriftEvidence> NewestScan(const DriftRecord& record, const std::vector<SensorState>& sensors,
                                      const DriftRules& rules) {
  DriftEvidence offset;
  DriftEvidence trend;
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    const bool baseline = std::isfinite(sensors[k].baseline_mm);
    const double sigma = baseline ? sensors[k].baseline_sigma_mm : rules.body_sigma_mm;
    offset.deviation.push_back(record.offset_mm[k] - (baseline ? sensors[k].baseline_mm : 0.0));
    const double person = rules.person_sigma_mm * rules.person_sigma_mm;
    const double scatter = sensors[k].scatter;
    offset.noise_variance.push_back(scatter * (VarianceOf(record.sigma_mm[k], rules) - person));
    offset.own_variance.push_back(scatter * person + sigma * sigma);
    trend.deviation.push_back(record.trend_mm_s[k]);
    const double whole = record.trend_sigma_mm_s[k] * record.trend_sigma_mm_s[k];
    trend.noise_variance.push_back(kTrendNoiseShare * whole);
    trend.own_variance.push_back((1.0 - kTrendNoiseShare) * whole);
  }
  return {std::move(offset), std::move(trend)};
}

std::vector<SensorBlock> BlocksOf(std::size_t sensors, const std::vector<RecordedBoard>& boards) {
  std::vector<SensorBlock> blocks;
  // Two or three side by side hide each other: what is seen best is that those beside them seem to read shorter.
  for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
    for (std::size_t sensor = 0; sensor < sensors; ++sensor) blocks.push_back({sensor, count});
  }
  for (const RecordedBoard& board : boards) {
    const bool part = board.sensor_count > 1 && board.sensor_count < sensors && board.first_sensor < sensors;
    if (part) blocks.push_back({board.first_sensor, board.sensor_count});
  }
  return blocks;
}

/// Adds what is not told already of the same sensor.
void Merge(std::vector<DriftAlarm>& alarms, const std::vector<DriftAlarm>& more) {
  for (const DriftAlarm& alarm : more) {
    const auto told = std::any_of(alarms.begin(), alarms.end(), [&](const DriftAlarm& old) {
      return old.sensor < alarm.sensor + alarm.count && alarm.sensor < old.sensor + old.count;
    });
    if (!told) alarms.push_back(alarm);
  }
}

}  // namespace

const char* DriftSinceName(DriftSince since) {
  switch (since) {
    case DriftSince::kBaseline:
      return "baseline";
    case DriftSince::kCalibration:
      return "calibration";
    case DriftSince::kWithinScan:
      break;
  }
  return "scan";
}

std::string DriftAlarm::Text() const {
  const std::string who =
      count == 1 ? "sensor " + std::to_string(sensor) + " reads"
                 : "sensors " + std::to_string(sensor) + " to " + std::to_string(sensor + count - 1) + " read";
  const char* against = since == DriftSince::kBaseline      ? "than it did after the calibration"
                        : since == DriftSince::kCalibration ? "than its neighbours, since the calibration"
                                                            : "than before, at the end of the newest scan";
  char text[160];
  std::snprintf(text, sizeof text, "%s %.2f mm (sd %.2f) %s %s", who.c_str(), std::abs(drift_mm), sigma_mm,
                drift_mm > 0.0 ? "longer" : "shorter", against);
  return text;
}

DriftState JudgeDrift(const DriftHistory& history, const std::vector<RecordedBoard>& boards, const DriftRules& rules) {
  ENSURE(rules.baseline_scans >= 2, "a baseline is a mean");
  DriftState state;
  const std::size_t first = history.SinceCalibration();
  state.scans = history.records().size() - first;
  state.baseline_ready = state.scans >= rules.baseline_scans;
  if (state.scans == 0) return state;
  for (std::size_t sensor = 0; sensor < history.sensors(); ++sensor) {
    SensorFilter filter(rules);
    for (std::size_t k = first; k < history.records().size(); ++k) {
      filter.Add(history.records()[k].offset_mm[sensor], history.records()[k].sigma_mm[sensor]);
    }
    state.sensors.push_back(filter.state());
  }
  const std::vector<SensorBlock> blocks = BlocksOf(history.sensors(), boards);
  for (const DriftSince since : {DriftSince::kBaseline, DriftSince::kCalibration}) {
    DriftPursuit pursuit(history.stencils(), blocks, {DeviationsFrom(since, state.sensors, rules)});
    Merge(state.alarms, FindAlarms(std::move(pursuit), {since, rules.limit_mm, rules.significance, 0.0}));
  }
  const DriftRecord& newest = history.records().back();
  // One by one: what two or three seem to do together in one scan is one body's shape as a rule.
  DriftPursuit pursuit(history.stencils(),
                       {blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(history.sensors())},
                       NewestScan(newest, state.sensors, rules));
  Merge(state.alarms, FindAlarms(std::move(pursuit), {DriftSince::kWithinScan, rules.scan_limit_mm,
                                                      rules.scan_significance, 0.5 * newest.duration_s}));
  std::stable_sort(state.alarms.begin(), state.alarms.end(), [](const DriftAlarm& a, const DriftAlarm& b) {
    return std::abs(a.drift_mm) > std::abs(b.drift_mm);
  });
  return state;
}

Result<DriftState> JudgeScanSoFar(DriftHistory history, const Scan& so_far, const DriftRules& rules) {
  const auto added = history.Add(EstimateDrift(so_far));
  if (!added) return Fail(added);
  return JudgeDrift(history, so_far.header.machine.boards, rules);
}

}  // namespace annulus
