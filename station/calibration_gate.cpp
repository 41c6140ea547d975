#include "station/calibration_gate.h"

#include <chrono>
#include <cmath>

#include "acquisition/reference_record.h"
#include "station/devices.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "arm a scan";

bool MustBeCalibrated(const Config& config) {
  using Uncalibrated = CalibrationConfig::Uncalibrated;
  if (config.calibration.uncalibrated != Uncalibrated::kByBooth) {
    return config.calibration.uncalibrated == Uncalibrated::kRefuse;
  }
  return config.ring.bus != RingBus::kSimulated;
}

/// Nothing if the ring was never calibrated. A file that the configuration names has to be there; one that a console
/// would have accepted need not.
Result<std::optional<CalibrationFile>> ReadFileInForce(const Config& config, Storage& storage) {
  const std::string path = CalibrationPath(config);
  const bool named = !config.calibration.file.empty();
  if (path.empty() || (!named && !storage.Exists(path))) return std::optional<CalibrationFile>();
  auto file = ReadCalibrationFile(storage, path);
  if (!file) return Fail(file);
  return std::optional(std::move(*file));
}

}  // namespace

bool IsTargetProfile(const std::string& profile) { return profile.rfind("target", 0) == 0; }

Result<RingCalibration> CalibrationInForce(const Config& config, const std::string& profile, Storage& storage) {
  RingCalibration ideal = RingCalibration::Ideal(config.ring.radius_mm);
  if (IsTargetProfile(profile)) return ideal;
  auto file = ReadFileInForce(config, storage);
  if (!file) return Fail(file);
  if (!*file) return ideal;
  RingCalibration& in_force = (*file)->calibration;
  if (in_force.sensors.size() != ideal.sensors.size()) {
    return Fail("use the calibration " + CalibrationPath(config),
                "it is of " + std::to_string(in_force.sensors.size()) + " sensors, the ring has " +
                    std::to_string(ideal.sensors.size()),
                "calibrate this ring, or name its own calibration in [calibration] file");
  }
  return std::move(in_force);
}

std::int64_t CalibrationGate::WallNow() const {
  return clock_ != nullptr ? clock_->WallNow().count() : SystemClock().WallNow().count();
}

Status CalibrationGate::AskCalibration(const ArmRequest& request, const RecordedMachine& machine) const {
  const std::string profile = request.search ? request.header.profile : request.plan.profile;
  if (IsTargetProfile(profile)) return {};
  const auto file = ReadFileInForce(config_, storage_);
  if (!file) return Fail(file);
  if (!*file) {
    if (!MustBeCalibrated(config_)) return {};
    return Fail(kAttempted,
                "the ring is not calibrated: none was accepted at the console, and [calibration] file names none",
                "calibrate the ring at the console and accept it, or with 'annulus calibrate' and name its CAL.json; "
                "or set [calibration] uncalibrated = \"mark\", and every result says so");
  }
  if ((*file)->calibration.certificate != request.header.calibration.certificate) {
    return Fail(kAttempted, "the calibration file was changed since the scan was asked for", "ask for the scan again");
  }
  return CheckCalibrationFor(**file, machine.boards, WallNow());
}

Status CalibrationGate::AskReference(const ArmRequest& request) const {
  const std::string& path = config_.calibration.reference_check;
  const std::string profile = request.search ? request.header.profile : request.plan.profile;
  // A check has to be possible where there is none yet.
  if (path.empty() || request.plan.of_target || IsTargetProfile(profile)) return {};
  const char* advice = "scan the reference cylinder with the profile check, and run 'annulus check'";
  const auto text = ReadTextFile(storage_, path);
  if (!text) return Fail(kAttempted, "there is no reference check of the ring: " + text.error().Text(), advice);
  const auto record = ParseReference(*text, path);
  if (!record) return Fail(record);
  const auto hours = static_cast<std::int64_t>(std::ceil(config_.calibration.reference_hours));
  return JudgeReference(*record, request.header, WallNow(), std::chrono::hours(hours));
}

GateAnswer CalibrationGate::Ask(const ArmRequest& request, const RecordedMachine& machine) {
  GateAnswer answer;
  answer.calibration = AskCalibration(request, machine);
  answer.reference = AskReference(request);
  return answer;
}

}  // namespace annulus
