// The control tick: interlock, deadlines, threads, lines, watchdog. Nothing here waits for a bus or a disk.

#include <algorithm>
#include <new>

#include "acquisition/scanner_state.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using In = InterlockInput;
using Out = InterlockOutput;

constexpr milliseconds kTickLate{12};     ///< From one tick to the next: three of them in a second are a warning.
constexpr milliseconds kTickOverrun{20};  ///< This is a stop.
constexpr milliseconds kHang{200};        ///< After this the watchdog relay has dropped: the program was not there.
constexpr std::size_t kMostLate = 3;
constexpr std::chrono::seconds kLateWindow{1};
/// The worker's longest silence: no call on a bus takes longer without a look at the clock, and enable is off 250 ms
/// after the last sign of life.
constexpr milliseconds kWorkerSilence{200};
/// At rest it may open files and devices.
constexpr std::chrono::seconds kWorkerSilenceAtRest{5};
/// A brake that has been closed for so long holds, whatever the drive says or does not say.
constexpr milliseconds kBrakeHolds{50};
constexpr std::size_t kMostLines = 1000;
/// After this the chain has been read twice since its contacts stopped the drive.
constexpr milliseconds kChainRead{20};
/// By which a wall clock that is set differs from one that is only corrected.
constexpr milliseconds kWallJump{500};

/// What the interlock's faults are to the machine; warnings are none.
std::optional<CauseCode> CodeOf(InterlockFault fault) {
  switch (fault) {
    case InterlockFault::kChannelsDisagree:
      return CauseCode::kChannelsDiffer;
    case InterlockFault::kWeldedContact:
      return CauseCode::kWeldedContact;
    case InterlockFault::kBrakeOpen:
      return CauseCode::kBrakeSlip;
    case InterlockFault::kWatchdogDropped:
    case InterlockFault::kNoEnableFeedback:
    case InterlockFault::kOutputDiffers:
    case InterlockFault::kLinesFailed:
      return CauseCode::kInterlock;
    case InterlockFault::kResetStuck:
    case InterlockFault::kLampLost:
      break;
  }
  return std::nullopt;
}

}  // namespace

void Scanner::State::Tick() {
  const nanoseconds now = clock.Now();
  if (const auto why = WhyBroken()) {
    ScanEvent event;
    event.kind = ScanEventKind::kAwoke;  // SAFE, whatever it was
    event.time = now;
    event.cause = {*why, *why == CauseCode::kMemory ? "the program ran out of memory" : "a bug of this program",
                   "press the reset button and acknowledge; if it happens again, restart the program", now};
    static_cast<void>(Handle(event));
    event.kind = ScanEventKind::kFaulted;  // and say why, whatever it was
    static_cast<void>(Handle(event));
    const std::scoped_lock lock(mutex);
    broken.reset();
  }
  JudgeTickTime(now);
  JudgeWallClock(now);
  const auto read = devices.interlock.Read();
  JudgeChain(read, now);
  JudgeDriveStop(now);
  JudgeTime(now);
  if (read) JudgeStop(*read);
  JudgeWorker(now);
  SetLines();
  LogLines(now);
  // Both threads have to live: a program that is half dead must not keep the relay in.
  bool beats = true;
  {
    const std::scoped_lock lock(mutex);
    beats = !worker_dead;
  }
  if (ticks++ % 2 == 0 && beats && !devices.interlock.KickWatchdog()) {
    // Said by the interlock's own diagnosis; the relay drops.
  }
}

void Scanner::State::JudgeTickTime(nanoseconds now) {
  const nanoseconds gap = last_tick ? now - *last_tick : nanoseconds(0);
  last_tick = now;
  {
    const std::scoped_lock lock(mutex);
    longest_tick = std::max(longest_tick, gap);
    ticked = now;
    JudgeGapLocked(gap, now);
  }
  if (gap <= kTickLate) return;
  late_ticks.push_back(now);
  while (now - late_ticks.front() > kLateWindow) late_ticks.pop_front();
  if (late_ticks.size() >= kMostLate) {
    Warn({WarningCode::kTicksLate, "the computer is busy: three control ticks in a second were late", {}});
  }
}

void Scanner::State::JudgeGapLocked(nanoseconds gap, nanoseconds now) {
  if (gap <= kTickOverrun) return;
  const std::string took = std::to_string(gap / milliseconds(1)) + " ms";
  ScanEvent event;
  event.time = now;
  if (gap > kHang) {
    event.kind = ScanEventKind::kAwoke;
    event.cause = {CauseCode::kHostHang, "the program stood still for " + took,
                   "look for what stopped it; then press the reset button", now};
  } else {
    const ScanState at = machine.state();
    if (at == ScanState::kSafe || at == ScanState::kIdle || at == ScanState::kFault) return;
    event.kind = ScanEventKind::kFaulted;
    event.cause = {CauseCode::kHostLate, "the control tick was late: " + took + " instead of 10 ms",
                   "close other programs; set up real-time priority (docs/booth.md)", now};
  }
  static_cast<void>(HandleLocked(event));
}

void Scanner::State::JudgeWallClock(nanoseconds now) {
  const nanoseconds offset = clock.WallNow() - now;
  const nanoseconds jump = wall_offset ? offset - *wall_offset : nanoseconds(0);
  wall_offset = offset;
  if (std::chrono::abs(jump) < kWallJump) return;
  const auto by_ms = jump / milliseconds(1);
  Warn({WarningCode::kWallClockSet,
        "the computer's wall clock was set by " + std::to_string(by_ms) + " ms",
        {static_cast<double>(by_ms)}});
}

std::optional<CauseCode> Scanner::State::WhyBroken() const {
  const std::scoped_lock lock(mutex);
  return broken;
}

void Scanner::State::BreakTick(CauseCode code) noexcept {
  // Without a beat from now on until a tick comes to its end: the relay drops if none does.
  {
    const std::scoped_lock lock(mutex);
    broken = broken.value_or(code);
  }
  try {
    static_cast<void>(devices.interlock.MakeSafe());
  } catch (...) {
    // Tried again at the next tick, which begins with SAFE.
  }
}

void Scanner::State::JudgeChain(const Result<InterlockReading>& read, nanoseconds now) {
  const std::vector<InterlockNotice> seen = devices.interlock.Diagnose();
  ScanEvent event;
  event.time = now;
  event.kind = ScanEventKind::kChainOpened;
  const std::scoped_lock lock(mutex);
  notices = seen;
  const bool latched = !read || read->latched;
  if (read) {
    reading = *read;
    if (read->start_pressed) {
      ++start_presses;
      start_version = machine.version();
      start_pressed_at = now;
    }
    if (!read->reset_refused.empty()) NoteLocked(now, "reset refused: " + read->reset_refused);
  } else {
    reading.held_by = read.error().seen;
    reading.latched = true;
  }
  if (latched) {
    bool told = false;
    for (const InterlockNotice& notice : seen) {
      const auto code = CodeOf(notice.fault);
      if (!code) continue;
      event.cause = {*code, notice.text, notice.advice, notice.since};
      event.cause.ends_with_reset = true;
      static_cast<void>(HandleLocked(event));
      told = true;
    }
    if (!told && machine.state() != ScanState::kSafe) {
      event.cause = {CauseCode::kChainOpen, reading.held_by,
                     "pull the emergency stop out, shut the door or leave the limit, then press the reset button", now};
      event.cause.ends_with_reset = true;
      static_cast<void>(HandleLocked(event));
    }
  } else if (machine.state() == ScanState::kSafe && (was_latched || read->reset_pressed)) {
    event.kind = ScanEventKind::kResetTaken;
    static_cast<void>(HandleLocked(event));
  }
  was_latched = latched;
}

void Scanner::State::JudgeTime(nanoseconds now) {
  const std::scoped_lock lock(mutex);
  for (auto due = machine.Due(now); due; due = machine.Due(now)) {
    // An axis that stands is not hurried: what is left of its stop is the drive's and the brake's.
    if (due->kind == ScanEventKind::kStopLate && at_rest) break;
    const ScanState before = machine.state();
    static_cast<void>(HandleLocked(*due));
    if (due->kind == ScanEventKind::kStopLate) {
      // A drive that does not do as it is told.
      due->kind = ScanEventKind::kFaulted;
      due->cause = {CauseCode::kStopOverdue, "the axis was not at rest 0.3 s after its stop, and was stopped hard",
                    "look for what keeps the drive from stopping; then home again", now};
      static_cast<void>(HandleLocked(*due));
      due->kind = ScanEventKind::kStopLate;
    }
    if (machine.state() == before && due->kind != ScanEventKind::kStopLate) break;
  }
}

void Scanner::State::JudgeStop(const InterlockReading& read) {
  const nanoseconds now = read.host_time;
  if (read[In::kBrakeFeedback]) {
    brake_closed_since.reset();
  } else if (!brake_closed_since) {
    brake_closed_since = now;
  }
  const std::scoped_lock lock(mutex);
  if (machine.state() != ScanState::kStopping || !brake_closed_since) return;
  const bool holds =
      machine.quick_stop_demanded() && now - std::max(*brake_closed_since, machine.since()) >= kBrakeHolds;
  if (powered && !holds) return;
  ScanEvent event;
  event.kind = ScanEventKind::kStopped;
  event.time = now;
  static_cast<void>(HandleLocked(event));
}

void Scanner::State::JudgeDriveStop(nanoseconds now) {
  const std::scoped_lock lock(mutex);
  if (!drive_stopped || (machine.may_move() && now - drive_stopped->time < kChainRead)) return;
  // Contacts have opened that nobody saw open: as a chain that is open, so that nothing goes on without a reset.
  ScanEvent event;
  event.kind = ScanEventKind::kChainOpened;
  event.time = now;
  event.cause = *drive_stopped;
  drive_stopped.reset();
  if (machine.may_move()) static_cast<void>(HandleLocked(event));
}

void Scanner::State::JudgeWorker(nanoseconds now) {
  nanoseconds silent{0};
  bool moving = false;
  {
    const std::scoped_lock lock(mutex);
    if (!beat) return;
    silent = now - *beat;
    // Once the drive is disabled the brake may still be closing, while the worker is with the disk already.
    moving = machine.may_move() || (machine.state() == ScanState::kStopping && powered);
    worker_dead = silent > (moving ? nanoseconds(kWorkerSilence) : nanoseconds(kWorkerSilenceAtRest));
    if (!worker_dead) return;
  }
  Fault({CauseCode::kThreadDead,
         "the thread that drives axis and ring says nothing for " + std::to_string(silent / milliseconds(1)) + " ms",
         "restart the program; report this if it happens again", now});
}

void Scanner::State::SetLines() {
  LineOrders wanted;
  {
    const std::scoped_lock lock(mutex);
    wanted = machine.Lines();
    // The checks before a scan end with what they were made for, even if the worker does not know it yet.
    const bool may_prove = machine.state() == ScanState::kIdle || machine.state() == ScanState::kArmed;
    wanted.emitters = wanted.emitters || (proving && may_prove);
    // Nobody brings the axis to rest any more: the quick stop does, and the enable relay's contacts after it.
    if (worker_dead) wanted.enable = wanted.quick_stop = wanted.emitters = false;
  }
  Interlock& interlock = devices.interlock;
  const auto set = [&](Out output, bool level) -> Status {
    return interlock.output(output) == level ? Status{} : interlock.Set(output, level);
  };
  // Off in the order of the danger, on in the other.
  if (!wanted.quick_stop) static_cast<void>(set(Out::kQuickStop, false));
  if (!wanted.emitters) static_cast<void>(set(Out::kEmitters, false));
  if (!wanted.enable) static_cast<void>(set(Out::kEnable, false));
  if (wanted.quick_stop) static_cast<void>(set(Out::kQuickStop, true));
  // Refused while the relay has not dropped out: tried again at the next tick; who waits for power has a deadline.
  if (wanted.enable) static_cast<void>(set(Out::kEnable, true));
  if (wanted.emitters) static_cast<void>(set(Out::kEmitters, true));
  static_cast<void>(set(Out::kLampReady, wanted.lamp_ready));
  static_cast<void>(set(Out::kLampRunning, wanted.lamp_running));
  static_cast<void>(set(Out::kLampFault, wanted.lamp_fault));
  bool acknowledge = false;
  {
    const std::scoped_lock lock(mutex);
    std::swap(acknowledge, chain_acknowledged);
  }
  if (!acknowledge) return;
  if (const Status ended = interlock.Acknowledge(); !ended) {
    Warn({WarningCode::kNotAcknowledged, ended.error().seen + ": " + ended.error().advice, {}});
  }
}

void Scanner::State::LogLines(nanoseconds now) {
  SafetyLines lines;
  const std::scoped_lock lock(mutex);
  lines.input = reading.level;
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    const auto output = static_cast<Out>(i);
    lines.output.at(i) = output != Out::kWatchdog && devices.interlock.output(output);
  }
  enable_ordered = lines.output[static_cast<std::size_t>(Out::kEnable)];
  if (last_lines && last_lines->input == lines.input && last_lines->output == lines.output) return;
  lines.time = now;
  last_lines = lines;
  if (lines_log.size() == kMostLines) lines_log.pop_front();
  lines_log.push_back(lines);
}

}  // namespace annulus
