#include "acquisition/scan_quality.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acquisition/quality_coverage.h"
#include "acquisition/quality_grid.h"
#include "acquisition/quality_motion.h"
#include "acquisition/quality_notices.h"
#include "acquisition/quality_sensors.h"
#include "acquisition/quality_weights.h"

namespace annulus {
namespace {

constexpr std::size_t kFewestSensors = 24;
constexpr double kLowestRow = 5.0;  // mm, of the coverage map

/// What a recorded plan says that matters here.
struct PlanFacts {
  double pitch_mm = 0.0;   ///< 0 where it is not known.
  bool of_target = false;  ///< A calibration target: nobody is judged.
};
PlanFacts FactsOf(const std::string& plan_json) {
  PlanFacts facts;
  const auto plan = nlohmann::json::parse(plan_json, nullptr, false);
  if (!plan.is_object()) return facts;
  facts.of_target = plan.value("of_target", nlohmann::json()) == true;
  const auto pitch = plan.find("pitch_mm");
  if (pitch == plan.end() || !pitch->is_number()) return facts;
  const auto value = pitch->get<double>();
  if (std::isfinite(value) && value > 0.0 && value < 1000.0) facts.pitch_mm = value;
  return facts;
}

/// Whether a notice makes sense of a target, which need not fill the ring and wears nothing.
bool ConcernsTargets(const QualityNotice& notice) {
  return notice.code == NoticeCode::kSensorsStuck || notice.code == NoticeCode::kNoise;
}

/// The pitch as it turned out: the median distance of neighbouring levels of a sweep.
double MeasuredPitch(const QualityGrid& grid) {
  std::vector<double> distances;
  for (std::size_t k = 1; k < grid.levels().size(); ++k) {
    if (grid.levels()[k].sweep == grid.levels()[k - 1].sweep) {
      distances.push_back(std::abs(grid.levels()[k].z - grid.levels()[k - 1].z));
    }
  }
  return distances.empty() ? 0.0 : MedianOf(distances);
}

}  // namespace

struct QualityMonitor::State {
  explicit State(const ScanHeader& header)
      : grid(header.calibration), watch(grid.columns()), plan(FactsOf(header.plan_json)) {}

  [[nodiscard]] bool judged() const { return grid.columns() >= kFewestSensors && !grid.levels().empty(); }
  /// Sensors of which `test` holds, ascending.
  template <class Test>
  [[nodiscard]] std::vector<std::size_t> Sensors(Test test) const {
    std::vector<std::size_t> sensors;
    for (std::size_t sensor = 0; sensor < grid.columns(); ++sensor) {
      if (test(watch.quality()[grid.ColumnOf(sensor)])) sensors.push_back(sensor);
    }
    return sensors;
  }
  [[nodiscard]] double DropoutRate() const {
    double expected = 0.0;
    double missing = 0.0;
    for (const SensorQuality& sensor : watch.quality()) {
      expected += sensor.expected;
      missing += sensor.missing;
    }
    return expected > 0.0 ? missing / expected : 0.0;
  }

  QualityGrid grid;
  SensorWatch watch;
  LeftWatch left;
  PlanFacts plan;
  std::size_t levels = 0;
};

QualityMonitor::QualityMonitor(const ScanHeader& header) : state_(std::make_unique<State>(header)) {}
QualityMonitor::QualityMonitor(QualityMonitor&&) noexcept = default;
QualityMonitor& QualityMonitor::operator=(QualityMonitor&&) noexcept = default;
QualityMonitor::~QualityMonitor() = default;

void QualityMonitor::Add(const ScanLevel& level) {
  ++state_->levels;
  if (state_->grid.levels().size() >= kMostLevels) return;
  state_->grid.Add(level);
  if (!state_->judged()) return;
  state_->watch.Update(state_->grid);
  state_->left.Update(state_->grid);
}

LiveQuality QualityMonitor::live() const {
  LiveQuality live;
  live.levels = state_->levels;
  if (!state_->judged()) return live;
  live.dropout_rate = state_->DropoutRate();
  const auto last = state_->grid.Radii(state_->grid.levels().size() - 1);
  const auto seen = std::count_if(last.begin(), last.end(), [](float r) { return r > 0.0F; });
  live.seen_share = static_cast<double>(seen) / static_cast<double>(last.size());
  if (!state_->plan.of_target) {
    live.dead = state_->Sensors([](const SensorQuality& sensor) { return sensor.dead; });
    live.left = state_->left.left().has_value();
  }
  live.stuck = state_->Sensors([](const SensorQuality& sensor) { return sensor.stuck; });
  live.sensors_verdict = JudgeDeadSensors(live.dead, state_->grid.columns());
  return live;
}

ScanQuality QualityMonitor::Assess() const {
  const State& state = *state_;
  ScanQuality quality;
  quality.levels = state.levels;
  quality.verdict = QualityVerdict::kUsable;
  if (!state.judged()) return quality;
  const double pitch = state.plan.pitch_mm > 0.0 ? state.plan.pitch_mm : MeasuredPitch(state.grid);
  quality.map = MapCoverage(state.grid, std::max(kLowestRow, pitch));
  quality.coverage = CoverageOf(quality.map);
  quality.gaps = RegionsOf(quality.map, CoverageCell::kGap, {});
  quality.dropout_rate = state.DropoutRate();
  quality.return_quality = MedianQuality(state.grid);
  quality.noise_sigma_mm = EstimateNoise(state.grid);
  quality.spike_rate = EstimateSpikes(state.grid, quality.noise_sigma_mm);
  quality.sensors.resize(state.grid.columns());
  for (std::size_t column = 0; column < state.grid.columns(); ++column) {
    quality.sensors[state.grid.SensorOf(column)] = state.watch.quality()[column];
  }
  if (!state.plan.of_target) {
    quality.sensors_verdict =
        JudgeDeadSensors(state.Sensors([](const SensorQuality& sensor) { return sensor.dead; }), state.grid.columns());
  }
  const std::vector<ComparedLevel> compared = CompareSweeps(state.grid);
  quality.motion = MotionOf(state.grid, compared);
  quality.notices = FindNotices(state.grid, compared, state.left, quality);
  if (state.plan.of_target) {
    std::erase_if(quality.notices, [](const QualityNotice& notice) { return !ConcernsTargets(notice); });
  }
  quality.verdict = QualityVerdict::kGood;
  for (const QualityNotice& notice : quality.notices) quality.verdict = std::max(quality.verdict, notice.verdict);
  return quality;
}

std::vector<float> QualityMonitor::Weights() const {
  if (!state_->judged()) return {};
  std::vector<float> weights =
      WeightsOf(state_->grid, state_->watch, state_->left.left() ? Comparing::kNone : Comparing::kSweeps);
  // Levels that came after the last one kept are as they are.
  if (!weights.empty()) weights.resize(state_->levels * state_->grid.columns(), 1.0F);
  return weights;
}

std::optional<MotionQuality> QualityMonitor::Motion() const {
  if (!state_->judged() || state_->left.left()) return std::nullopt;
  return MotionOf(state_->grid, CompareSweeps(state_->grid));
}

namespace {

QualityMonitor Watched(const Scan& scan) {
  QualityMonitor monitor(scan.header);
  for (const ScanLevel& level : scan.levels) monitor.Add(level);
  return monitor;
}

}  // namespace

ScanQuality AssessScan(const Scan& scan) { return Watched(scan).Assess(); }
std::vector<float> QualityWeights(const Scan& scan) { return Watched(scan).Weights(); }
std::optional<MotionQuality> MeasureMotion(const Scan& scan) { return Watched(scan).Motion(); }

}  // namespace annulus
