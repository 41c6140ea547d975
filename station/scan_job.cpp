#include "station/scan_job.h"

#include <utility>

#include "acquisition/recording.h"
#include "base/ensure.h"
#include "station/command_line.h"
#include "station/devices.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr double kHeadRoomMm = 40.0;  // scanned above the highest point, as the built-in profiles do

/// Passes what the scanner takes on to the recording.
class RecordingSink final : public ScanSink {
 public:
  explicit RecordingSink(RecordingWriter& writer) : writer_(writer) {}
  Status AppendLevel(const ScanLevel& level) override { return writer_.AppendLevel(level); }
  Status AppendAxis(nanoseconds time, double z_mm) override { return writer_.AppendAxis(time, z_mm); }
  Status AppendEvent(nanoseconds time, const std::string& text) override { return writer_.AppendEvent(time, text); }

 private:
  RecordingWriter& writer_;
};

/// The booth and its devices, opened through the drivers. The ground outlives them.
struct Devices {
  std::unique_ptr<DeviceGround> ground;
  RingDevice ring_device;
  AxisDevice axis_device;
  [[nodiscard]] RangeRing& ring() { return *ring_device.ring; }
  [[nodiscard]] ScanAxis& axis() { return *axis_device.axis; }
  [[nodiscard]] Clock& clock() { return ground->clock(); }
};

Result<Devices> OpenDevices(const Config& config, Storage& storage) {
  auto ground = DeviceGround::Make(config, storage);
  if (!ground) return Fail(ground);
  auto ring = OpenRing(config.ring, **ground);
  if (!ring) return Fail(ring);
  auto axis = OpenAxis(config.axis, **ground);
  if (!axis) return Fail(axis);
  return Devices{std::move(*ground), std::move(*ring), std::move(*axis)};
}

bool IsBuiltInProfile(const std::string& name) {
  return name == "body" || name == "torso" || name == "head" || name == "breath";
}

/// A profile that only the configuration knows starts from nothing: all its lengths must be given.
Result<ScanPlan> OwnPlan(const std::string& name, const ProfileConfig& profile) {
  std::string missing;
  const auto need = [&](const std::optional<double>& value, const char* key) {
    if (!value) missing += (missing.empty() ? "" : ", ") + std::string(key);
  };
  if (!profile.find_top) need(profile.z_top_mm, "z_top_mm");
  need(profile.z_bottom_mm, "z_bottom_mm");
  need(profile.pitch_mm, "pitch_mm");
  need(profile.speed_mm_s, "speed_mm_s");
  if (!missing.empty()) {
    return Fail("plan a scan with profile '" + name + "'", "[profile." + name + "] has no " + missing,
                "add it to the configuration");
  }
  ScanPlan plan;
  plan.profile = name;
  plan.level_rate_hz = *profile.speed_mm_s > 0.0 ? *profile.speed_mm_s / *profile.pitch_mm : 30.0;
  plan.dwell_s = 20.0;  // of a parked ring
  return plan;
}

void Override(ScanPlan& plan, const ProfileConfig& profile) {
  if (profile.z_top_mm) plan.z_top_mm = *profile.z_top_mm;
  if (profile.z_bottom_mm) plan.z_bottom_mm = *profile.z_bottom_mm;
  if (profile.pitch_mm) plan.pitch_mm = *profile.pitch_mm;
  if (profile.speed_mm_s) plan.speed_mm_s = *profile.speed_mm_s;
  if (profile.sweeps) plan.sweeps = *profile.sweeps;
  if (profile.level_rate_hz) plan.level_rate_hz = *profile.level_rate_hz;
}

/// The plan that was asked for, not yet held against the machine.
Result<ScanPlan> RequestedPlan(const Config& config, const std::string& name, Devices& devices,
                               const TaskContext& task) {
  const auto found = config.profiles.find(name);
  const ProfileConfig profile = found != config.profiles.end() ? found->second : ProfileConfig{};
  const bool built_in = IsBuiltInProfile(name);
  std::optional<Millimetres> height;
  if (profile.find_top || (name == "head" && !profile.z_top_mm)) {
    const auto top = FindSubjectTop(devices.ring(), devices.axis(), devices.clock(), task);
    if (!top) return Fail(top);
    height = *top;
  } else if (profile.z_top_mm && name == "head") {
    height = Millimetres(*profile.z_top_mm - kHeadRoomMm);
  }
  auto plan = built_in || found == config.profiles.end() ? BuiltInPlan(name, height) : OwnPlan(name, profile);
  if (!plan) return plan;
  Override(*plan, profile);
  if (!built_in && height) plan->z_top_mm = height->value() + kHeadRoomMm;
  return plan;
}

ScanHeader HeaderFor(const Config& config, const ScanRequest& request, const ScanPlan& plan,
                     const sim::BoothDevices& booth) {
  ScanHeader header;
  header.station_id = config.station_id;
  header.source = booth.subject().name();
  header.subject_id = request.subject_id;
  header.consent_reference = request.consent_reference;
  header.program_version = ProgramVersion();
  header.ring_radius_mm = config.ring.radius_mm;
  header.calibration = RingCalibration::Ideal(config.ring.radius_mm);
  header.profile = request.profile;
  header.plan_json = PlanJson(plan);
  header.seed = config.sim.seed;
  return header;
}

/// After an error: ends the recording if it holds anything, and says so; else nothing is left.
Error KeepWhatWasTaken(RecordingWriter& writer, const std::string& path, nanoseconds now, Error error) {
  const std::uint64_t levels = writer.level_count();
  if (levels > 0 && writer.AppendEvent(now, "stopped: " + error.seen) && writer.Finish()) {
    error.advice += "; the " + std::to_string(levels) + " levels taken before are in " + path;
  } else {
    writer.Discard();
  }
  return error;
}

/// The scan itself, from the reasons of the plan to the last level.
Result<ScanSummary> Take(Devices& devices, const ScanOutcome& outcome, RecordingWriter& writer,
                         const TaskContext& task) {
  Clock& clock = devices.clock();
  RecordingSink sink(writer);
  for (const std::string& reason : outcome.adjusted) {
    RETURN_IF_ERROR(sink.AppendEvent(clock.Now(), "plan adjusted: " + reason));
  }
  auto summary = RunScan(devices.ring(), devices.axis(), outcome.plan, sink, clock, task);
  if (summary && writer.level_count() == 0 && !summary->cancelled) {
    return Fail("scan", "not one level was taken", "check ring and plan");
  }
  return summary;
}

}  // namespace

Result<ScanOutcome> RunScanJob(const Config& config, const ScanRequest& request, Storage& storage,
                               const TaskContext& task) {
  ENSURE(AllSimulated(config), "the devices are simulated");
  auto devices = OpenDevices(config, storage);
  if (!devices) return Fail(devices);
  const auto wanted = RequestedPlan(config, request.profile, *devices, task);
  if (!wanted) return Fail(wanted);
  const PlanCheck check = ValidatePlan(*wanted, devices->axis().identity().limits, devices->ring().limits());
  if (check.verdict == PlanVerdict::kInvalid) {
    std::string reasons;
    for (const std::string& reason : check.reasons) reasons += (reasons.empty() ? "" : "; ") + reason;
    return Fail("plan a scan with profile '" + request.profile + "'", reasons,
                "change [profile." + request.profile + "] of the configuration");
  }
  ScanHeader header = HeaderFor(config, request, check.plan, *devices->ground->booth());
  header.wall_start_ns = devices->clock().WallNow().count();
  auto writer = RecordingWriter::Create(storage, request.out, header);
  if (!writer) return Fail(writer);
  ScanOutcome outcome{check.plan, check.reasons, {}, false};
  const auto keep = [&](const Error& error) {
    return tl::unexpected(KeepWhatWasTaken(*writer, request.out, devices->clock().Now(), error));
  };
  const auto summary = Take(*devices, outcome, *writer, task);
  if (!summary) return keep(summary.error());
  outcome.summary = *summary;
  outcome.recorded = writer->level_count() > 0;
  if (!outcome.recorded) {
    writer->Discard();
    return outcome;
  }
  const Status finished = writer->Finish();
  if (!finished) return keep(finished.error());
  return outcome;
}

}  // namespace annulus
