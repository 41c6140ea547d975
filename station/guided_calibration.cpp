#include "station/guided_calibration.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <random>
#include <utility>

#include "acquisition/recording.h"
#include "base/units.h"
#include "station/calibration_job.h"
#include "station/command_io.h"
#include "station/devices.h"
#include "station/scan_job.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "calibrate the ring";
constexpr int kMostTries = 3;

using Say = std::function<Status(const std::string&)>;

/// One placement, until it is good.
class GuidedStep {
 public:
  GuidedStep(const CalibrationGuide& guide, std::size_t step, PlacementTaker& taker, const Say& say)
      : guide_(guide), step_(step), taker_(taker), say_(say) {}

  Result<Scan> Take(const std::string& file, const TaskContext& task) {
    const PlannedPlacement& placement = guide_.plan().placements[step_];
    for (int attempt = 1;; ++attempt) {
      auto taken = taker_.Take(guide_.plan(), step_, file, task);
      if (!taken) return Fail(taken);
      seconds_ += taken->seconds;
      reading_ = TargetScanOf(taken->scan, placement, file, guide_.plan().ambient_c);
      const PlacementCheck check = guide_.Check(step_, reading_);
      if (check.readings > 0) RETURN_IF_ERROR(say_("  " + check.Text()));
      const bool late = taken->seconds > CalibrationGuide::kStepBudget;
      RETURN_IF_ERROR(say_(fmt::format("  took {:.0f} s of {:.0f} s{}", taken->seconds, CalibrationGuide::kStepBudget,
                                       late ? ": longer than planned" : "")));
      for (const std::string& problem : check.problems) RETURN_IF_ERROR(say_("  not good: " + problem));
      if (check.good) return std::move(taken->scan);
      if (attempt == kMostTries) {
        return Fail(
            kAttempted,
            fmt::format("placement {} did not succeed in {} tries: {}", step_ + 1, kMostTries, check.problems.front()),
            "mend that, then start again");
      }
      RETURN_IF_ERROR(say_(fmt::format("  again, try {} of {}", attempt + 1, kMostTries)));
    }
  }

  [[nodiscard]] TargetScan TakeReadings() { return std::move(reading_); }
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  const CalibrationGuide& guide_;
  std::size_t step_;
  PlacementTaker& taker_;
  const Say& say_;
  TargetScan reading_;
  double seconds_ = 0.0;
};

}  // namespace

BoothPlacements::BoothPlacements(Config config, Storage& storage, const KeySource* keys)
    : config_(std::move(config)), storage_(storage), keys_(keys), simulated_(AllSimulated(config_)) {}

Result<TakenPlacement> BoothPlacements::Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                                             const TaskContext& task) {
  const PlannedPlacement& placement = plan.placements[step];
  const CalibrationTarget& target = plan.targets[placement.target];
  Config config = config_;
  if (simulated_) config.sim.target = SimulatedTarget(target, placement, step);
  const bool fine = target.kind == CalibrationTarget::Kind::kStep;
  const ScanRequest request{fine ? "target_fine" : "target", file, "", "", keys_};
  const auto start = std::chrono::steady_clock::now();
  const auto outcome = RunScanJob(config, request, storage_, task);
  if (!outcome) return Fail(outcome);
  if (outcome->summary.cancelled) return tl::unexpected(InterruptedError(kAttempted));
  auto scan = ReadRecording(storage_, file, keys_);
  if (!scan) return Fail(scan);
  TakenPlacement taken{std::move(*scan), 0.0};
  if (simulated_) {
    // Somebody needs a while to move the target; the booth's own clock says how long the scan took.
    constexpr double kHandling = 15.0;
    taken.seconds = kHandling + std::chrono::duration<double>(outcome->summary.end - outcome->summary.start).count();
  } else {
    taken.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  return taken;
}

SimTarget BoothPlacements::SimulatedTarget(const CalibrationTarget& target, const PlannedPlacement& placement,
                                           std::size_t step) const {
  std::mt19937_64 random(config_.sim.seed * 7919 + step);
  const auto off = [&](double most) { return most * (2.0 * static_cast<double>(random() >> 11U) * 0x1p-53 - 1.0); };
  SimTarget simulated;
  simulated.out_of_round_mm = 0.12;
  simulated.seed = config_.sim.seed;
  const std::optional<SimTarget>& described = config_.sim.target;
  if (described && described->target.kind == target.kind && described->target.radius_mm == target.radius_mm) {
    simulated = *described;
  }
  simulated.target = target;
  simulated.seed += placement.target;
  const double tilt = RadiansFromDegrees(placement.tilt_deg + off(placement.tilt_deg > 0.0 ? 0.8 : 0.2));
  const double to = RadiansFromDegrees(placement.tilt_to_deg + off(10.0));
  simulated.placement.tilt_x = -tilt * std::sin(to);
  simulated.placement.tilt_y = tilt * std::cos(to);
  simulated.placement.turn_rad = RadiansFromDegrees(placement.turn_deg.value_or(0.0) + off(1.5));
  constexpr double kMiddle = 650.0;  // mm; of the profile's heights
  simulated.placement.x_mm = placement.x_mm + off(6.0) - kMiddle * std::tan(tilt) * std::cos(to);
  simulated.placement.y_mm = placement.y_mm + off(6.0) - kMiddle * std::tan(tilt) * std::sin(to);
  return simulated;
}

Result<GuidedScans> RunGuidedCalibration(const CalibrationGuide& guide, const std::string& folder,
                                         PlacementTaker& taker, const Say& say, const TaskContext& task) {
  GuidedScans all;
  std::vector<TargetScan> readings;
  for (std::size_t step = 0; step < guide.steps(); ++step) {
    RETURN_IF_ERROR(say(guide.Instruction(step)));
    const std::string file = fmt::format("{}/placement-{}.mcap", folder, step + 1);
    GuidedStep one(guide, step, taker, say);
    auto scan = one.Take(file, task);
    if (!scan) return Fail(scan);
    all.scans.push_back(std::move(*scan));
    all.files.push_back(file);
    all.seconds += one.seconds();
    readings.push_back(one.TakeReadings());
    if (guide.plan().placements[step].verify) continue;
    RETURN_IF_ERROR(say("  " + guide.SolveSoFar(readings, task).Text()));
  }
  RETURN_IF_ERROR(say(fmt::format("all placements scanned in {:.1f} min", all.seconds / 60.0)));
  return all;
}

}  // namespace annulus
