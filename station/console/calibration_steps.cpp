#include "station/console/calibration_steps.h"

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <thread>

#include "acquisition/recording.h"
#include "station/devices.h"

namespace annulus {
namespace {

using namespace std::chrono_literals;

constexpr const char* kAttempted = "scan a placement";
constexpr auto kLook = 50ms;
constexpr auto kHoming = 120s;
constexpr auto kArming = 60s;
constexpr auto kKey = 300s;  ///< For somebody to walk to the booth and press the start key.
constexpr auto kScanning = 300s;

/// One placement on boothd's booth, step by step. The top function reads as what is done at the booth.
class LinkScan {
 public:
  LinkScan(BoothLink& booth, const Clock& clock, const TaskContext& task) : booth_(booth), clock_(clock), task_(task) {}

  /// The recording that boothd made.
  Result<std::string> Run(const std::string& profile, const std::string& out) {
    RETURN_IF_ERROR(Home());
    RETURN_IF_ERROR(Arm(profile, out));
    const std::uint64_t before = LastScan();
    RETURN_IF_ERROR(StartWithKey());
    return WaitForResult(before);
  }

 private:
  Status Home() {
    const auto status = booth_.status();
    if (status && status->scanner.homed) return {};
    RETURN_IF_ERROR(booth_.Ask(HomeOrder{}));
    return WaitFor("bring the carriage home", kHoming, [](const ScannerStatus& s) { return s.homed && s.job.empty(); });
  }

  Status Arm(const std::string& profile, const std::string& out) {
    ArmOrder order;
    order.profile = profile;
    order.out = out;
    RETURN_IF_ERROR(booth_.Ask(order));
    const Status armed =
        WaitFor("arm", kArming, [](const ScannerStatus& s) { return s.state == ScanState::kArmed || s.job.empty(); });
    if (!armed) return armed;
    const auto status = booth_.status();
    if (status && status->scanner.state == ScanState::kArmed) return {};
    if (status && status->scanner.arm) {
      for (const ArmCheck& check : status->scanner.arm->checks) RETURN_IF_ERROR(check.result);
    }
    return Fail(kAttempted, "the booth did not arm", "look at the booth's state");
  }

  Status StartWithKey() {
    task_.Report("press the start key at the booth once the target stands", 0.0, 1.0);
    const auto deadline = clock_.Now() + kKey;
    while (!booth_.start_agreed()) {
      if (task_.stop.stop_requested()) return Stopped();
      if (clock_.Now() >= deadline) {
        static_cast<void>(booth_.Cancel());
        return Fail(kAttempted, "nobody pressed the start key at the booth in five minutes", "try again");
      }
      std::this_thread::sleep_for(kLook);
    }
    const auto status = booth_.status();
    if (!status) return Fail(kAttempted, "the booth went away", "look at boothd, and try again");
    return booth_.Ask(StartOrder{status->scanner.version});
  }

  [[nodiscard]] std::uint64_t LastScan() const {
    const auto status = booth_.status();
    return status && status->scanner.scan ? status->scanner.scan->number : 0;
  }

  Result<std::string> WaitForResult(std::uint64_t before) {
    RETURN_IF_ERROR(WaitFor("scan", kScanning, [before](const ScannerStatus& s) {
      return s.scan && s.scan->number > before && s.state != ScanState::kScanning && s.state != ScanState::kStopping;
    }));
    const auto status = booth_.status();
    if (!status || !status->scanner.scan) return Fail(kAttempted, "the booth went away", "try again");
    const ScanResult& scan = *status->scanner.scan;
    RETURN_IF_ERROR(scan.status);
    if (scan.recorded && scan.complete) return scan.recording;
    return Fail(kAttempted, "the scan did not come to its end", "try again");
  }

  /// Until the booth is as wanted. Fails on a fault, a stop, when the booth is away, and when it takes too long.
  Status WaitFor(const char* what, std::chrono::seconds longest,
                 const std::function<bool(const ScannerStatus&)>& done) {
    const auto deadline = clock_.Now() + longest;
    for (;;) {
      std::this_thread::sleep_for(kLook);
      if (task_.stop.stop_requested()) return Stopped();
      const auto status = booth_.status();
      if (!status) return Fail(kAttempted, "the booth is away", "look at boothd, and try again");
      const ScannerStatus& s = status->scanner;
      if (s.state == ScanState::kFault) {
        return s.causes.empty() ? Fail(kAttempted, "the booth reports a fault", "look at its state")
                                : Fail(kAttempted, s.causes.front().text, s.causes.front().advice);
      }
      if (done(s)) return {};
      task_.Report(s.stage.empty() ? what : s.stage, s.done, s.total);
      if (clock_.Now() >= deadline) {
        static_cast<void>(booth_.Cancel());
        return Fail(kAttempted, fmt::format("to {} took longer than {} s", what, longest.count()),
                    "look at the booth's state, and try again");
      }
    }
  }

  Status Stopped() {
    static_cast<void>(booth_.Cancel());
    return Fail(kAttempted, "it was stopped", "begin again");
  }

  BoothLink& booth_;
  const Clock& clock_;
  const TaskContext& task_;
};

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted.push_back('\\');
    quoted.push_back(c);
  }
  return quoted + "\"";
}

/// A simulated booth of its own whose scans carry the station's date: its clock begins in 2000, and to boothd a
/// calibration of that time is long out of date.
class SimulatedPlacements final : public PlacementTaker {
 public:
  SimulatedPlacements(const Config& config, Storage& storage, const Clock& clock)
      : booth_(config, storage, nullptr), storage_(storage), clock_(clock) {}

  Result<TakenPlacement> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                              const TaskContext& task) override {
    auto taken = booth_.Take(plan, step, file, task);
    if (!taken) return taken;
    taken->scan.header.wall_start_ns = clock_.WallNow().count();
    RETURN_IF_ERROR(storage_.Remove(file));
    RETURN_IF_ERROR(WriteRecording(storage_, file, taken->scan));
    return taken;
  }

 private:
  BoothPlacements booth_;
  Storage& storage_;
  const Clock& clock_;
};

}  // namespace

Result<TakenPlacement> LinkPlacements::Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                                            const TaskContext& task) {
  const CalibrationTarget& target = plan.targets[plan.placements[step].target];
  const bool fine = target.kind == CalibrationTarget::Kind::kStep;
  const auto start = clock_.Now();
  const std::string out = fmt::format("calibration-{}-{}.mcap", clock_.WallNow().count() / 1'000'000'000, step + 1);
  const auto recording = LinkScan(booth_, clock_, task).Run(fine ? "target_fine" : "target", out);
  if (!recording) return Fail(recording);
  auto scan = ReadRecording(storage_, *recording, keys_);
  if (!scan) return Fail(scan);
  if (storage_.Exists(file)) RETURN_IF_ERROR(storage_.Remove(file));
  RETURN_IF_ERROR(WriteRecording(storage_, file, *scan));
  const double seconds = std::chrono::duration<double>(clock_.Now() - start).count();
  return TakenPlacement{std::move(*scan), seconds};
}

std::unique_ptr<PlacementTaker> PlacementTakerFor(const Config& config, BoothLink& booth, Storage& storage,
                                                  const Clock& clock, const KeySource* keys) {
  if (AllSimulated(config)) return std::make_unique<SimulatedPlacements>(config, storage, clock);
  return std::make_unique<LinkPlacements>(booth, storage, clock, keys);
}

std::string CalibrationPlanToml(const CalibrationPlan& plan, const std::vector<std::string>& targets) {
  std::string text = fmt::format("technician = {}\nambient_c = {}\nvalid_days = {}\n", Quoted(plan.technician),
                                 plan.ambient_c, plan.valid_days);
  for (const std::string& target : targets) text += fmt::format("\n[[target]]\nspec = {}\n", Quoted(target));
  for (const PlannedPlacement& placement : plan.placements) {
    text +=
        fmt::format("\n[[placement]]\ntarget = {}\nx_mm = {}\ny_mm = {}\ntilt_deg = {}\ntilt_to_deg = {}\n",
                    placement.target + 1, placement.x_mm, placement.y_mm, placement.tilt_deg, placement.tilt_to_deg);
    if (placement.turn_deg) text += fmt::format("turn_deg = {}\n", *placement.turn_deg);
    if (placement.temperature_c) text += fmt::format("temperature_c = {}\n", *placement.temperature_c);
    text += fmt::format("scan = {}\nverify = {}\n", Quoted(placement.scan), placement.verify);
  }
  return text;
}

}  // namespace annulus
