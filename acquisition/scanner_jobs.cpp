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
constexpr milliseconds kRampTime{400};           ///< From the highest speed to rest, on the normal ramp.
constexpr milliseconds kPowerTime{900};          ///< Relay, drop-out of the last time included.
constexpr std::chrono::seconds kHomingPause{3};  ///< Where a homing run turns, it stands for less.
constexpr milliseconds kBrakeTime{300};          ///< From the drive's brake output to the switch.
constexpr milliseconds kContacts{30};            ///< From the relay's feedback to the drive's inputs.
constexpr milliseconds kReopenPatience{300};     ///< One attempt to find lost devices, in the background.
constexpr milliseconds kReopenPause{500};
constexpr std::chrono::seconds kRecoverPatience{5};

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
  nanoseconds moved = devices.clock.Now();
  for (bool homed = false; !homed && !Stopping();) {
    devices.clock.SleepUntil(devices.clock.Now() + kPoll);
    const auto now = axis.Position();
    if (!now) return Fail(now);
    homed = now->fresh && now->homed && !now->moving;
    if (now->moving || homed) moved = devices.clock.Now();
    if (devices.clock.Now() - moved < kHomingPause) continue;
    const Error error{"home the axis", "it stands still, and has not found its home switch",
                      "look for an obstacle, and for who else drives the axis; then home it again"};
    OnFault({CauseCode::kHoming, error.seen, error.advice, moved});
    return tl::unexpected<Error>(error);
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
  if (!found) return Warn({WarningCode::kNotAcknowledged, found.error().seen + ": " + found.error().advice, {}});
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
  at_rest = !seen.moving;
}

}  // namespace annulus
