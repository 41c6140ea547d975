#include <algorithm>
#include <cmath>
#include <optional>
#include <stop_token>

#include "acquisition/level_stamper.h"
#include "acquisition/scan_run.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr double kSearchPitchMm = 5.0;
constexpr double kSearchSpeed = 150.0;
/// A level meets the subject when this share of the sensors says so: a lone false return is not a head.
constexpr double kSearchShare = 1.0 / 6.0;
constexpr int kSearchLevels = 2;

/// Asks for a stop as soon as levels in a row meet something.
class TopFinder final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    if (top_) return {};
    const auto met = std::count_if(level.readings.begin(), level.readings.end(),
                                   [](const RangeReading& reading) { return std::isfinite(reading.range_mm); });
    if (static_cast<double>(met) < kSearchShare * static_cast<double>(level.readings.size())) {
      in_a_row_ = 0;
      return {};
    }
    if (in_a_row_++ == 0) first_mm_ = MeanHeight(level);
    if (in_a_row_ == kSearchLevels) {
      top_ = first_mm_;
      stop_.request_stop();
    }
    return {};
  }
  Status AppendAxis(nanoseconds, double) override { return {}; }
  Status AppendEvent(nanoseconds, const std::string&) override { return {}; }

  [[nodiscard]] std::stop_source& stop() { return stop_; }
  [[nodiscard]] std::optional<double> top() const { return top_; }

 private:
  std::stop_source stop_;
  std::optional<double> top_;
  double first_mm_ = 0.0;
  int in_a_row_ = 0;
};

}  // namespace

ScanPlan SearchPlan(const AxisLimits& limits) {
  ScanPlan plan;
  plan.profile = "search";
  plan.pitch_mm = kSearchPitchMm;
  plan.speed_mm_s = std::min(kSearchSpeed, limits.max_speed.value());
  plan.level_rate_hz = plan.speed_mm_s / kSearchPitchMm;
  const double run_up = RunUp(plan, limits).value();
  plan.z_top_mm = limits.z_max.value() - run_up;
  plan.z_bottom_mm = std::max(0.0, limits.z_min.value() + run_up);
  return plan;
}

Result<Millimetres> FindSubjectTop(RangeRing& ring, ScanAxis& axis, Clock& clock, const TaskContext& task) {
  const ScanPlan plan = SearchPlan(axis.identity().limits);
  TopFinder finder;
  const std::stop_callback pass_on(task.stop, [&finder] { finder.stop().request_stop(); });
  const auto searched = RunScan(ring, axis, plan, finder, clock, {task.progress, finder.stop().get_token()});
  if (!searched) return Fail(searched);
  if (finder.top()) return Millimetres(*finder.top());
  if (searched->cancelled) return Fail("find the subject's top", "stopped on request", "start again");
  return Fail("find the subject's top", "nothing in the ring between its top and the floor",
              "ask the subject to stand in the middle of the ring");
}

}  // namespace annulus
