// What the worker thread does: one order after the other, and a look at the axis in between.

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "acquisition/scanner_state.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using In = InterlockInput;

constexpr milliseconds kPoll{5};
constexpr milliseconds kRampTime{400};   ///< From the highest speed to rest, on the normal ramp.
constexpr milliseconds kPowerTime{900};  ///< Relay, drop-out of the last time included.
constexpr milliseconds kBrakeTime{300};  ///< From the drive's brake output to the switch.
constexpr milliseconds kContacts{30};    ///< From the relay's feedback to the drive's inputs.
constexpr milliseconds kFirstLevel{500};
constexpr int kProvingLevels = 2;
constexpr std::uint64_t kScansOfSpace = 5;
constexpr std::chrono::seconds kSettlePatience{9};  ///< With the disk, after the last level.
constexpr milliseconds kReopenPatience{300};        ///< One attempt to find lost devices, in the background.
constexpr milliseconds kReopenPause{500};
constexpr std::chrono::seconds kRecoverPatience{5};
constexpr std::chrono::seconds kArmPatience{2};  ///< The same, when a scan is wanted.
/// A wall clock before this was never set.
constexpr nanoseconds kClockSane = std::chrono::seconds(946'684'800);

std::string Joined(const std::vector<std::string>& reasons) {
  std::string text;
  for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

/// What stopped a scan if neither a device nor the disk has told it: stamps that cannot be, or a bug.
CauseCode CodeOf(const Error& error) {
  const bool of_a_board = error.seen.find("ring board") != std::string::npos;
  return of_a_board ? CauseCode::kSensorData : CauseCode::kInternal;
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

// --- the loop ---

void Scanner::State::Step() {
  Job job = Job::kNone;
  {
    const std::scoped_lock lock(mutex);
    std::swap(job, order);
    running = job;
    job_stop_token = job_stop.get_token();
    stage.clear();
    done = total = 0.0;
    beat = clock.Now();
  }
  try {
    if (job == Job::kNone) {
      Idle();
    } else {
      Run(job);
    }
  } catch (const std::bad_alloc&) {
    Break(job, CauseCode::kMemory, "the program ran out of memory");
  } catch (const std::exception& error) {
    Break(job, CauseCode::kInternal, error.what());
  }
  const std::scoped_lock lock(mutex);
  running = Job::kNone;
  proving = false;  // also after an exception
}

void Scanner::State::Break(Job job, CauseCode code, const char* what) noexcept {
  const char* advice = code == CauseCode::kMemory ? "restart the program" : "report this, with the log";
  try {
    Fault({code, what, advice, clock.Now()});
    StopHard();
    if (job == Job::kScan && writer) ConcludeBroken({"scan", what, advice});
  } catch (...) {
    // The control thread makes everything safe.
    const std::scoped_lock lock(mutex);
    broken = broken.value_or(code);
  }
}

void Scanner::State::ConcludeBroken(const Error& error) {
  try {
    return Conclude(tl::unexpected<Error>(error));
  } catch (const std::exception&) {
    // It broke off while the recording was ended: what is on the disk stays as it is.
  }
  if (devices.tap != nullptr) devices.tap->Detach();
  ScanResult ended;
  ended.number = scan_number;
  ended.plan = plan;
  ended.status = tl::unexpected<Error>(error);
  if (writer) {
    ended.recorded = writer->level_count() > 0;
    ended.recording = writer->temporary_path();
    writer.reset();
  }
  const std::scoped_lock lock(mutex);
  result = std::move(ended);
}

void Scanner::State::Run(Job job) {
  switch (job) {
    case Job::kHome:
      if (!Home()) StopHard();
      return;
    case Job::kArm:
      return Arm();
    case Job::kScan:
      return armed.search ? Search() : Scan();
    case Job::kJog:
      if (!Jog()) StopHard();
      return;
    case Job::kRecover:
      return Recover();
    case Job::kNone:
      return;
  }
}

void Scanner::State::Idle() {
  const nanoseconds now = devices.clock.Now();
  bool lost = false;
  {
    const std::scoped_lock lock(mutex);
    // A ring that is lost in IDLE is looked for when a scan is wanted: until then the axis is watched without a gap.
    lost = device_lost && machine.state() != ScanState::kIdle;
    if (machine.state() != ScanState::kArmed) armed_longest = nanoseconds(0);
  }
  if (writer && state() != ScanState::kArmed && state() != ScanState::kScanning) {
    DropRecording();  // armed in vain: nothing was taken
  }
  if (lost && now >= next_reopen) {
    next_reopen = now + kReopenPause;
    static_cast<void>(ReopenDevices(kReopenPatience));
  } else if (!lost) {
    static_cast<void>(axis.Position());  // told to the machine if it fails
  }
  static_cast<void>(DrainLogs());  // told to the machine, too
  devices.clock.SleepUntil(now + scan_time::kTick);
}

TaskContext Scanner::State::Task() {
  TaskContext task;
  task.stop = job_stop_token;
  task.progress = [this](std::string_view name, double units, double of) {
    const std::scoped_lock lock(mutex);
    stage = name;
    done = units;
    total = of;
  };
  return task;
}

// --- stopping ---

Status Scanner::State::BringToRest() {
  if (axis.state() == ScanAxis::State::kEnabled) {
    RETURN_IF_ERROR(axis.Halt());
    const nanoseconds deadline = devices.clock.Now() + kRampTime;
    for (bool moving = true; moving;) {
      const auto now = axis.Position();
      if (!now) return Fail(now);
      moving = !now->fresh || now->moving;
      if (moving && devices.clock.Now() >= deadline) {
        RETURN_IF_ERROR(axis.QuickStop());
        break;
      }
      if (moving) devices.clock.SleepUntil(devices.clock.Now() + kPoll);
    }
  }
  RETURN_IF_ERROR(axis.Disable());
  return AwaitBrake();
}

Status Scanner::State::AwaitBrake() {
  for (const nanoseconds deadline = devices.clock.Now() + kBrakeTime;;) {
    {
      const std::scoped_lock lock(mutex);
      if (!reading[In::kBrakeFeedback]) return {};
    }
    const nanoseconds now = devices.clock.Now();
    if (now >= deadline) {
      const Error error{"wait for the brake", "it says that it is released though the drive is disabled",
                        "secure the carriage; check brake and its switch"};
      OnFault({CauseCode::kBrakeSlip, error.seen, error.advice, now});
      return tl::unexpected<Error>(error);
    }
    devices.clock.SleepUntil(now + kPoll);
  }
}

void Scanner::State::StopHard() {
  if (axis.state() != ScanAxis::State::kDisabled) static_cast<void>(devices.axis.QuickStop());
  static_cast<void>(axis.Disable());
  if (devices.ring.state() != RangeRing::State::kIdle) static_cast<void>(devices.ring.Stop());
}

// --- homing and jogging ---

Status Scanner::State::Home() {
  RETURN_IF_ERROR(axis.Enable());
  RETURN_IF_ERROR(axis.StartHoming());
  RETURN_IF_ERROR(SeekHome());
  const bool cancelled = Stopping();
  RETURN_IF_ERROR(BringToRest());
  if (cancelled) return {};
  ScanEvent event;
  event.kind = ScanEventKind::kHomed;
  event.time = devices.clock.Now();
  return Handle(event);
}

Status Scanner::State::SeekHome() {
  const TaskContext task = Task();
  task.Report("home the axis", 0, 1);
  // The first reading may still tell of an earlier homing; the driver forgets that when it orders a new one.
  for (bool homed = false; !homed && !Stopping();) {
    devices.clock.SleepUntil(devices.clock.Now() + kPoll);
    const auto now = axis.Position();
    if (!now) return Fail(now);
    homed = now->fresh && now->homed && !now->moving;
  }
  return {};
}

Status Scanner::State::Jog() {
  RETURN_IF_ERROR(axis.Enable());
  const auto from = axis.Position();
  if (!from) return Fail(from);
  const AxisLimits& limits = axis.identity().limits;
  JogDirection direction = JogDirection::kUp;
  {
    const std::scoped_lock lock(mutex);
    direction = jog_direction;
  }
  const double speed = std::min(options.jog_speed_mm_s, limits.max_speed.value());
  if (!Stopping()) {
    RETURN_IF_ERROR(
        axis.MoveTo(direction == JogDirection::kUp ? limits.z_max : limits.z_min, MillimetresPerSecond(speed)));
  }
  while (!Stopping()) {
    devices.clock.SleepUntil(devices.clock.Now() + kPoll);
    if (const auto now = axis.Position(); !now) return Fail(now);
  }
  return BringToRest();
}

// --- arming ---

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
  const auto check = [&report](std::string name, Status outcome) {
    report.checks.push_back({std::move(name), std::move(outcome)});
  };
  const TaskContext task = Task();
  task.Report("check the booth", 0, 1);
  {
    const std::scoped_lock lock(mutex);
    check("watchdog_relay", relay_tested);
    check("chain", reading.latched ? Fail("arm a scan", reading.held_by, "press the reset button") : Status{});
    check("homed", machine.homed() ? Status{} : Fail("arm a scan", "the axis is not homed", "home it"));
    check("alarms", machine.causes().empty()
                        ? Status{}
                        : Fail("arm a scan", machine.causes().front().text, machine.causes().front().advice));
    const bool stuck = std::any_of(notices.begin(), notices.end(), [](const InterlockNotice& notice) {
      return notice.fault == InterlockFault::kResetStuck && notice.present;
    });
    check("buttons",
          stuck ? Fail("arm a scan", "the reset button is pressed all the time", "release or mend it") : Status{});
    check("brake", reading[In::kBrakeFeedback]
                       ? Fail("arm a scan", "the brake says that it is released", "check brake and its switch")
                       : Status{});
  }
  check("drive", devices.axis.Verify());
  const GateAnswer answer = gate.Ask(armed);
  check("customer", answer.customer);
  check("consent", answer.consent);
  check("store", answer.store);
  check("reference", answer.reference);
  check("wall_clock", clock.WallNow() >= kClockSane
                          ? Status{}
                          : Fail("arm a scan", "the computer's clock is not set", "set date and time"));
  if (options.host_checks) {
    for (ArmCheck& one : options.host_checks()) report.checks.push_back(std::move(one));
  }
  check("ring", ProveRing());
  Status planned;
  if (armed.search) {
    plan = {};
    plan.speed_mm_s = 100.0;
    plan.z_top_mm = axis.identity().limits.z_max.value();
  } else {
    const PlanCheck checked = ValidatePlan(armed.plan, axis.identity().limits, ring.limits());
    plan = checked.plan;
    report.plan_adjusted = checked.reasons;
    if (checked.verdict == PlanVerdict::kInvalid) {
      planned = Fail("plan the scan", Joined(checked.reasons), "change the profile");
      report.plan_adjusted.clear();
    }
  }
  check("plan", planned);
  if (!armed.search) check("disk", report.passed() ? MakeRecording(report.plan_adjusted) : Status{});
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
  {
    const std::scoped_lock lock(mutex);
    proving = true;
  }
  const auto prove = [this]() -> Status {
    RETURN_IF_ERROR(devices.ring.Start(devices.ring.limits().min_level_rate.value() > 10.0
                                           ? devices.ring.limits().min_level_rate
                                           : Hertz(std::min(30.0, devices.ring.limits().max_level_rate.value()))));
    for (int i = 0; i < kProvingLevels; ++i) {
      if (const auto level = devices.ring.NextLevel(devices.clock.Now() + kFirstLevel); !level) return Fail(level);
    }
    return {};
  };
  Status proved = prove();
  const RingTrouble trouble = proved ? RingTrouble::kNone : devices.ring.trouble();
  if (devices.ring.state() != RangeRing::State::kIdle) {
    const Status stopped = devices.ring.Stop();
    if (proved) proved = stopped;
  }
  const std::scoped_lock lock(mutex);
  proving = false;
  if (trouble != RingTrouble::kNone && trouble != RingTrouble::kOrder) device_lost = true;
  return proved;
}

Status Scanner::State::MakeRecording(const std::vector<std::string>& plan_adjusted) {
  const std::uint64_t needed = RecordingReserve(plan.TotalLevels(), devices.ring.limits().sensor_count);
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
  return machine_now;
}

// --- scanning ---

void Scanner::State::Search() {
  Result<ScanSummary> summary = ScanSummary{};
  const auto top = FindSubjectTop(ring, axis, devices.clock, Task());
  ScanResult found;
  found.number = ++scan_number;
  if (top) {
    found.top = *top;
    found.complete = true;
  } else {
    found.status = Fail(top);
  }
  ScanEvent event;
  event.kind = ScanEventKind::kLastLevel;
  event.time = devices.clock.Now();
  const std::scoped_lock lock(mutex);
  static_cast<void>(HandleLocked(event));
  if (!found.status && !machine.causes().empty()) {
    const ScanCause& cause = machine.causes().front();
    found.status = Fail("find the subject's top", cause.text, cause.advice);
  }
  result = std::move(found);
}

void Scanner::State::Scan() {
  settling_since.reset();
  Conclude(RunScan(ring, axis, plan, *this, devices.clock, Task()));
}

void Scanner::State::Conclude(Result<ScanSummary> summary) {
  ScanResult ended;
  ended.number = ++scan_number;
  ended.plan = plan;
  ended.recording = armed.out;
  if (summary) {
    ended.summary = *summary;
    if (summary->levels == 0 && !summary->cancelled) {
      ended.status = Fail("scan", "not one level was taken", "check ring and plan");
    }
  } else {
    ended.status = Fail(summary);
    ended.summary.planned_levels = plan.TotalLevels();
    ended.summary.levels = static_cast<std::uint32_t>(writer->level_count());
    // Told already if a device or the disk failed, and no fault if it was refused because of a stop between two steps.
    if (!Stopping()) {
      Fault({settling_since ? CauseCode::kStorage : CodeOf(summary.error()),
             summary.error().attempted + ": " + summary.error().seen, summary.error().advice, devices.clock.Now()});
    }
  }
  if (state() == ScanState::kStopping || state() == ScanState::kScanning) StopHard();
  if (devices.tap != nullptr) devices.tap->Detach();
  EndRecording(ended);
  ended.complete = ended.complete && ended.status && !ended.summary.cancelled;
  const std::scoped_lock lock(mutex);
  if (!ended.status && machine.causes().empty()) {
    ended.status = {};
    ended.summary.cancelled = true;
  }
  // The first cause is why it ended, whatever failed of it next.
  if (!machine.causes().empty()) {
    const ScanCause& cause = machine.causes().front();
    ended.status = Fail("scan", cause.text, cause.advice);
    ended.complete = false;
  }
  result = std::move(ended);
}

void Scanner::State::EndRecording(ScanResult& ended) {
  static_cast<void>(DrainLogs());
  const std::uint64_t levels = writer->level_count();
  if (levels == 0) {
    writer->Discard();
    writer.reset();
    return;
  }
  if (!ended.status) {
    static_cast<void>(writer->AppendEvent(devices.clock.Now(), "stopped: " + ended.status.error().seen));
  }
  ended.quality = quality->Assess();
  static_cast<void>(writer->AppendEvent(devices.clock.Now(), "quality: " + JsonFromQuality(*ended.quality)));
  const Status finished = Kept(writer->Finish());
  ended.recorded = true;
  if (finished) {
    ended.complete = levels + ended.summary.missing_levels == plan.TotalLevels() && ended.summary.missing_levels == 0;
  } else {
    ended.recording = writer->temporary_path();
    if (ended.status) ended.status = finished;
  }
  writer.reset();
}

Status Scanner::State::DrainLogs() {
  std::deque<std::pair<nanoseconds, std::string>> texts;
  std::deque<SafetyLines> lines;
  {
    const std::scoped_lock lock(mutex);
    if (!writer) return {};
    texts.swap(notes);
    lines.swap(lines_log);
  }
  for (const auto& [time, text] : texts) RETURN_IF_ERROR(Kept(writer->AppendEvent(time, text)));
  for (const SafetyLines& one : lines) RETURN_IF_ERROR(Kept(writer->AppendSafety(one)));
  if (devices.tap != nullptr) return Kept(devices.tap->status());
  return {};
}

Status Scanner::State::Kept(Status status) {
  if (!status) {
    const Error& error = status.error();
    Fault({CauseCode::kStorage, error.attempted + ": " + error.seen, error.advice, clock.Now()});
  }
  return status;
}

Status Scanner::State::AppendLevel(const ScanLevel& level) {
  RETURN_IF_ERROR(DrainLogs());
  RETURN_IF_ERROR(Kept(writer->AppendLevel(level)));
  if (const std::string slow = writer->disk_note(); !slow.empty()) Warn(slow);
  if (options.on_level) options.on_level(level);
  return JudgeQuality(level);
}

Status Scanner::State::JudgeQuality(const ScanLevel& level) {
  quality->Add(level);
  const LiveQuality now = quality->live();
  {
    const std::scoped_lock lock(mutex);
    live = now;
  }
  if (now.sensors_verdict != SensorsVerdict::kRefuse) return {};
  std::string dead;
  for (const std::size_t sensor : now.dead) dead += (dead.empty() ? "" : ", ") + std::to_string(sensor);
  // The level itself is recorded and counts; the cause stops the scan.
  Fault({CauseCode::kSensorsDead, "too many sensors see nothing: " + dead,
         "clean their windows; if that does not help, have the boards looked at", devices.clock.Now()});
  return {};
}

Status Scanner::State::AppendAxis(nanoseconds time, double z_mm) { return Kept(writer->AppendAxis(time, z_mm)); }

Status Scanner::State::AppendEvent(nanoseconds time, const std::string& text) {
  return Kept(writer->AppendEvent(time, text));
}

Status Scanner::State::AppendRaw(RawRecord record) {
  // Without taps nothing could be replayed.
  return devices.tap == nullptr ? Status{} : Kept(writer->AppendRaw(std::move(record)));
}

Result<bool> Scanner::State::Settle() {
  auto settled = writer->Settle();
  if (!settled) static_cast<void>(Kept(Fail(settled)));
  if (!settled) return settled;
  const nanoseconds now = devices.clock.Now();
  if (!settling_since) settling_since = now;
  if (!*settled && now - *settling_since > kSettlePatience) {
    return Fail(Kept(Fail("bring the scan to the disk", "the disk did not take it in time",
                          "check the disk; what it has taken is kept")));
  }
  if (!*settled) return false;
  ScanEvent event;
  event.kind = ScanEventKind::kLastLevel;
  event.time = now;
  RETURN_IF_ERROR(Handle(event));
  return true;
}

// --- lost devices ---

Status Scanner::State::ReopenDevices(nanoseconds patience) {
  const nanoseconds deadline = devices.clock.Now() + patience;
  if (devices.ring.state() != RangeRing::State::kIdle) static_cast<void>(devices.ring.Stop());
  RETURN_IF_ERROR(devices.ring.Reopen(deadline));
  // A drive that answers keeps its link; whatever it says, it has to home again.
  if (!devices.axis.Position()) RETURN_IF_ERROR(axis.Reopen(devices.clock.Now() + patience));
  const std::scoped_lock lock(mutex);
  device_lost = false;
  NoteLocked(clock.Now(), "ring and axis are there again");
  return {};
}

void Scanner::State::Recover() {
  const TaskContext task = Task();
  task.Report("look for the devices", 0, 1);
  bool lost = false;
  {
    const std::scoped_lock lock(mutex);
    lost = device_lost;
  }
  Status found = lost ? ReopenDevices(kRecoverPatience) : Status{};
  if (found) found = axis.Disable();
  if (found) {
    const auto seen = axis.Position();
    if (!seen) found = Fail(seen);
  }
  if (found) found = devices.axis.Verify();
  if (!found) return Warn(found.error().seen + ": " + found.error().advice);
  ScanEvent event;
  event.kind = ScanEventKind::kAcknowledged;
  event.role = CauseRole::kService;  // whoever acknowledged was asked for the role when the order was taken
  const std::scoped_lock lock(mutex);
  event.time = clock.Now();
  if (machine.causes().size() != acknowledged_causes) return;  // something new, which nobody has seen yet
  warnings.clear();
  static_cast<void>(HandleLocked(event));
}

// --- what the devices ask and tell ---

Status Scanner::State::MayMove() {
  const std::scoped_lock lock(mutex);
  // Nothing moves while nobody looks at the chain.
  const nanoseconds now = clock.Now();
  if (ticked) JudgeGapLocked(now - *ticked, now);
  if (machine.may_move()) return {};
  return Fail("move the axis", std::string("the booth is ") + ScanStateText(machine.state()),
              machine.causes().empty() ? "wait, then give the order again" : machine.causes().front().advice);
}

Status Scanner::State::AwaitPower() {
  const nanoseconds deadline = devices.clock.Now() + kPowerTime;
  nanoseconds ready = nanoseconds::max();  // when the contacts behind the feedback have closed, too
  while (true) {
    {
      const std::scoped_lock lock(mutex);
      if (!machine.may_move()) return Fail("give the axis power", "a stop is demanded", "remove its cause first");
      const bool on = reading[In::kEnableFeedback] && enable_ordered;
      if (!on) ready = nanoseconds::max();
      if (on && ready == nanoseconds::max()) ready = clock.Now() + kContacts;
      if (clock.Now() >= ready) {
        // Together with the look at the state: a stop that comes next waits until the power is off again.
        powered = true;
        return {};
      }
    }
    const nanoseconds now = devices.clock.Now();
    if (now >= deadline) {
      const Error error{"give the axis power", "the enable relay did not pull in",
                        "check the safety chain, then press the reset button"};
      OnFault({CauseCode::kInterlock, error.seen, error.advice, now});
      return tl::unexpected<Error>(error);
    }
    devices.clock.SleepUntil(now + kPoll);
  }
}

void Scanner::State::OnDriveStopped(const ScanCause& cause) {
  const std::scoped_lock lock(mutex);
  if (ticked) JudgeGapLocked(cause.time - *ticked, cause.time);
  NoteLocked(cause.time, "the drive was stopped by its inputs: " + cause.text);
  // After a stop that is known already it is its consequence.
  if (!machine.may_move()) return;
  if (!drive_stopped) drive_stopped = cause;
  job_stop.request_stop();
}

void Scanner::State::OnPower(bool on) {
  const std::scoped_lock lock(mutex);
  powered = on;
}

void Scanner::State::OnPosition(const AxisPosition& seen) {
  const std::scoped_lock lock(mutex);
  position = seen;
  position_known = true;
  at_rest = !seen.moving;
}

}  // namespace annulus
