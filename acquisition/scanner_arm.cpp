// Arming: all checks before a scan, the ring tried, the recording begun.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "acquisition/scanner_state.h"
#include "base/ensure.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using In = InterlockInput;

constexpr milliseconds kFirstLevel{500};
constexpr int kProvingLevels = 2;
constexpr std::uint64_t kScansOfSpace = 5;
constexpr std::chrono::seconds kArmPatience{2};  ///< With boards that were lost.
constexpr double kProvingRateHz = 30.0;
/// A wall clock before this was never set.
constexpr nanoseconds kClockSane = std::chrono::seconds(946'684'800);

std::string Joined(const std::vector<std::string>& reasons) {
  std::string text;
  for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

/// Of the boards that said something of the level.
std::optional<double> MeanTemperature(const RingLevel& level) {
  double sum = 0.0;
  int count = 0;
  for (const BoardStamp& board : level.boards) {
    if (!board.present) continue;
    sum += board.temperature_c;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

/// Longest that a scan of this plan can take, from the start key to the last level on the disk.
nanoseconds LongestOf(const ScanPlan& plan, const AxisLimits& limits) {
  double seconds = plan.dwell_s;
  if (!plan.parked()) {
    const double length = plan.z_top_mm - plan.z_bottom_mm + 2.0 * RunUp(plan, limits).value();
    seconds = plan.sweeps * (length / plan.speed_mm_s + 2.0);
  }
  const double travel = (limits.z_max - limits.z_min).value() / limits.max_speed.value();
  return nanoseconds(static_cast<std::int64_t>((1.5 * seconds + travel + 15.0) * 1e9));
}

}  // namespace

void Scanner::State::Arm() {
  {
    const std::scoped_lock lock(mutex);
    armed = std::move(*request);
    request.reset();
  }
  DropRecording();
  ArmReport report;
  const Status passed = Check(report);
  ScanEvent event;
  event.kind = ScanEventKind::kArmed;
  event.time = devices.clock.Now();
  const std::scoped_lock lock(mutex);
  arm_report = std::move(report);
  if (!passed || Stopping()) {
    // What was armed before is given up: its recording is gone.
    event.kind = ScanEventKind::kCancelled;
    if (machine.state() == ScanState::kArmed) static_cast<void>(HandleLocked(event));
    return;
  }
  // What is armed is told before the state is, so that nobody starts something else.
  armed_longest = LongestOf(plan, axis.identity().limits);
  if (!HandleLocked(event)) armed_longest = nanoseconds(0);
}

void Scanner::State::DropRecording() {
  if (devices.tap != nullptr) devices.tap->Detach();
  if (writer) writer->Discard();
  writer.reset();
}

Status Scanner::State::Check(ArmReport& report) {
  using Code = ArmCheckCode;
  const auto check = [&report](ArmCheckCode code, Status outcome) {
    report.checks.push_back({ArmCheckName(code), std::move(outcome)});
  };
  const TaskContext task = Task();
  task.Report("check the booth", 0, 1);
  {
    const std::scoped_lock lock(mutex);
    check(Code::kWatchdogRelay, relay_tested);
    check(Code::kChain, reading.latched ? Fail("arm a scan", reading.held_by, "press the reset button") : Status{});
    check(Code::kHomed, machine.homed() ? Status{} : Fail("arm a scan", "the axis is not homed", "home it"));
    check(Code::kAlarms, machine.causes().empty()
                             ? Status{}
                             : Fail("arm a scan", machine.causes().front().text, machine.causes().front().advice));
    const bool stuck = std::any_of(notices.begin(), notices.end(), [](const InterlockNotice& notice) {
      return notice.fault == InterlockFault::kResetStuck && notice.present;
    });
    check(Code::kButtons,
          stuck ? Fail("arm a scan", "the reset button is pressed all the time", "release or mend it") : Status{});
    check(Code::kBrake, reading[In::kBrakeFeedback]
                            ? Fail("arm a scan", "the brake says that it is released", "check brake and its switch")
                            : Status{});
  }
  check(Code::kDrive, devices.axis.Verify());
  const GateAnswer answer = gate.Ask(armed, Machine());
  check(Code::kCustomer, answer.customer);
  check(Code::kConsent, answer.consent);
  check(Code::kStore, answer.store);
  check(Code::kCalibration, answer.calibration);
  check(Code::kReference, answer.reference);
  check(Code::kWallClock, clock.WallNow() >= kClockSane
                              ? Status{}
                              : Fail("arm a scan", "the computer's clock is not set", "set date and time"));
  if (options.host_checks) {
    for (ArmCheck& one : options.host_checks()) report.checks.push_back(std::move(one));
  }
  check(Code::kRing, ProveRing());
  WatchTemperature();
  Status planned;
  if (armed.search) {
    plan = SearchPlan(axis.identity().limits);
  } else {
    const PlanCheck checked = ValidatePlan(armed.plan, axis.identity().limits, ring.limits());
    plan = checked.plan;
    report.plan_adjusted = checked.reasons;
    if (checked.verdict == PlanVerdict::kInvalid) {
      planned = Fail("plan the scan", Joined(checked.reasons), "change the profile");
      report.plan_adjusted.clear();
    }
  }
  check(Code::kPlan, planned);
  if (!armed.search) check(Code::kDisk, report.passed() ? MakeRecording(report.plan_adjusted) : Status{});
  return report.passed() ? Status{} : Fail("arm a scan", "not all checks passed", "see the list");
}

Status Scanner::State::ProveRing() {
  bool lost = false;
  {
    const std::scoped_lock lock(mutex);
    lost = device_lost;
  }
  // A board may have been unplugged, or have restarted, since the last scan.
  if (lost) RETURN_IF_ERROR(ReopenDevices(kArmPatience));
  if (!lost && ReferenceLost()) RETURN_IF_ERROR(devices.ring.Reopen(devices.clock.Now() + kArmPatience));
  {
    const std::scoped_lock lock(mutex);
    proving = true;
  }
  const auto prove = [this]() -> Status {
    const RingLimits& limits = devices.ring.limits();
    RETURN_IF_ERROR(devices.ring.Start(
        Hertz(std::clamp(kProvingRateHz, limits.min_level_rate.value(), limits.max_level_rate.value()))));
    for (int i = 0; i < kProvingLevels; ++i) {
      const auto level = devices.ring.NextLevel(devices.clock.Now() + kFirstLevel);
      if (!level) return Fail(level);
      ring_temperature_c = MeanTemperature(*level);
    }
    return {};
  };
  Status proved = prove();
  const RingTrouble trouble = proved ? RingTrouble::kNone : devices.ring.trouble();
  if (devices.ring.state() != RangeRing::State::kIdle) {
    const Status stopped = devices.ring.Stop();
    if (proved) proved = stopped;
  }
  WatchReference();
  const std::scoped_lock lock(mutex);
  proving = false;
  if (trouble != RingTrouble::kNone && trouble != RingTrouble::kOrder) device_lost = true;
  return proved;
}

bool Scanner::State::ReferenceLost() const {
  const ReferenceBoard* reference = devices.ring.reference();
  return reference != nullptr && reference->board && !reference->trouble.empty();
}

void Scanner::State::WatchReference() {
  const ReferenceBoard* reference = devices.ring.reference();
  if (reference == nullptr) return;
  std::optional<ScanWarning> warning;
  if (!reference->trouble.empty()) {
    warning = {WarningCode::kReferenceLost,
               "reference board " + std::to_string(reference->serial) +
                   " gives no readings, scans do without: " + reference->trouble,
               {static_cast<double>(reference->serial)}};
  }
  const std::scoped_lock lock(mutex);
  reference_lost = std::move(warning);
}

void Scanner::State::WatchTemperature() {
  constexpr double kFar = 5.0;  // degrees: offsets of a ring are known to rise by up to some 0.05 mm per degree
  const RingCalibration& calibration = armed.header.calibration;
  std::optional<ScanWarning> warning;
  const bool unknown = !calibration.certificate.empty() && calibration.range_mm_per_c == 0.0;
  if (unknown && ring_temperature_c && std::abs(*ring_temperature_c - calibration.reference_c) > kFar) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the ring has %.0f degrees, it was calibrated at %.0f, and how its ranges change with temperature is "
                  "not known: let it warm up, or calibrate it at this temperature",
                  *ring_temperature_c, calibration.reference_c);
    warning = {WarningCode::kRingTemperature, text, {*ring_temperature_c, calibration.reference_c}};
  }
  const std::scoped_lock lock(mutex);
  far_temperature = std::move(warning);
}

Status Scanner::State::MakeRecording(const std::vector<std::string>& plan_adjusted) {
  const ReferenceBoard* reference = devices.ring.reference();
  const std::size_t sensors = devices.ring.limits().sensor_count + (reference != nullptr ? kSensorsPerBoard : 0);
  const std::uint64_t needed = RecordingReserve(plan.TotalLevels(), sensors);
  const auto room = storage.FreeBytes(armed.out);
  if (!room) return Fail(room);
  if (*room < kScansOfSpace * needed) {
    return Fail("reserve disk space for the scan",
                std::to_string(*room >> 20) + " MB are free, " + std::to_string((kScansOfSpace * needed) >> 20) +
                    " MB (five scans) are needed",
                "free space on the disk, or record to another one");
  }
  ScanHeader header = armed.header;
  header.plan_json = PlanJson(plan);
  header.wall_start_ns = clock.WallNow().count();
  header.machine = Machine();
  if (ring_temperature_c && header.calibration.range_mm_per_c != 0.0) {
    header.calibration = header.calibration.AtTemperature(*ring_temperature_c);
  }
  ENSURE(header.reference.has_value() == (reference != nullptr), "who arms knows where the reference sensors stand");
  if (reference != nullptr && reference->board) {
    header.reference->firmware_version = reference->board->firmware_version;
  }
  RecordingOptions recording = options.recording;
  recording.reserve_bytes = needed;
  auto made = RecordingWriter::Create(storage, armed.out, header, recording);
  if (!made) return Fail(made);
  writer = std::move(*made);
  quality.emplace(header);
  {
    const std::scoped_lock lock(mutex);
    notes.clear();
    lines_log.clear();
  }
  for (const std::string& reason : plan_adjusted) {
    RETURN_IF_ERROR(writer->AppendEvent(devices.clock.Now(), "plan adjusted: " + reason));
  }
  if (far_temperature) {
    RETURN_IF_ERROR(writer->AppendEvent(devices.clock.Now(), "warning: " + far_temperature->text));
  }
  return devices.tap == nullptr ? Status{} : devices.tap->Attach(*writer);
}

RecordedMachine Scanner::State::Machine() const {
  RecordedMachine machine_now;
  machine_now.ring_bus = armed.header.machine.ring_bus;
  for (const RingBoard& board : devices.ring.boards()) {
    machine_now.boards.push_back(
        {board.serial, board.first_sensor, board.sensor_count, board.protocol_version, board.firmware_version});
  }
  const AxisIdentity& identity = devices.axis.identity();
  machine_now.axis_serial = identity.serial;
  machine_now.axis_protocol_version = identity.protocol_version;
  machine_now.axis_firmware_version = identity.firmware_version;
  machine_now.axis_z_min_mm = identity.limits.z_min.value();
  machine_now.axis_z_max_mm = identity.limits.z_max.value();
  machine_now.axis_max_speed_mm_s = identity.limits.max_speed.value();
  machine_now.axis_max_acceleration_mm_s2 = identity.limits.max_acceleration.value();
  machine_now.level_rate_hz = plan.level_rate_hz;
  machine_now.ring_temperature_c = ring_temperature_c;
  return machine_now;
}

}  // namespace annulus
