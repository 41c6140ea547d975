#include "acquisition/scan_machine.h"

#include <algorithm>
#include <array>

#include "base/ensure.h"

namespace annulus {
namespace {

using State = ScanState;
using Kind = ScanEventKind;

/// What an event means in a state.
enum class Outcome {
  kNothing,  ///< "-"
  kRefused,  ///< "no"
  kSafe,
  kIdle,
  kHoming,
  kArmed,
  kScanning,
  kStopping,
  kFault,
  kJog,
};

constexpr std::array<std::array<Outcome, kScanStates>, kScanEventKinds> MakeTable() {
  using enum Outcome;
  constexpr auto N = kNothing;
  constexpr auto R = kRefused;
  // SAFE, IDLE, HOMING, ARMED, SCANNING, STOPPING, FAULT, JOG
  return {{
      {kSafe, kSafe, kSafe, kSafe, kSafe, kSafe, kSafe, kSafe},                     // chain opened
      {kIdle, N, N, N, N, N, N, N},                                                 // reset taken
      {R, kHoming, R, R, R, R, R, R},                                               // home ordered
      {N, N, kIdle, N, N, N, N, N},                                                 // homed
      {N, N, kStopping, N, N, N, N, N},                                             // homing failed
      {R, kArmed, R, kArmed, R, R, R, R},                                           // armed
      {R, R, R, kScanning, R, R, R, R},                                             // started
      {N, N, N, N, kStopping, N, N, N},                                             // last level
      {N, N, kStopping, kIdle, kStopping, N, N, kStopping},                         // cancelled
      {N, N, N, kIdle, N, N, N, N},                                                 // arm expired
      {kSafe, kFault, kStopping, kFault, kStopping, kStopping, kFault, kStopping},  // faulted
      {N, N, N, N, N, kIdle, N, N},                                                 // stopped
      {N, N, N, N, N, kStopping, N, N},                                             // stop late
      {N, N, N, N, N, kSafe, N, N},                                                 // stop overdue
      {R, R, R, R, R, R, kIdle, R},                                                 // acknowledged
      {R, kJog, R, R, R, R, R, kJog},                                               // jog ordered
      {N, N, N, N, N, N, N, kStopping},                                             // jog released
      {kSafe, kSafe, kSafe, kSafe, kSafe, kSafe, kSafe, kSafe},                     // awoke
  }};
}
constexpr auto kTable = MakeTable();

Outcome OutcomeOf(Kind kind, State state) {
  return kTable.at(static_cast<std::size_t>(kind)).at(static_cast<std::size_t>(state));
}

State StateOf(Outcome outcome) {
  ENSURE(outcome > Outcome::kRefused, "the outcome is a state");
  return static_cast<State>(static_cast<int>(outcome) - static_cast<int>(Outcome::kSafe));
}

bool EndsWithReset(const ScanCause& cause) { return cause.ends_with_reset || cause.code == CauseCode::kChainOpen; }

/// What somebody in this state can do to get on.
const char* WayOn(State state) {
  switch (state) {
    case State::kSafe:
      return "close the chain, then press the reset button";
    case State::kIdle:
      return "home the axis if it is not homed, then arm a scan";
    case State::kHoming:
      return "wait until the axis is homed, or cancel";
    case State::kArmed:
      return "start, or cancel";
    case State::kScanning:
      return "wait for the end of the scan, or cancel";
    case State::kStopping:
      return "wait until the axis rests";
    case State::kFault:
      return "remove the cause, then acknowledge it";
    case State::kJog:
      return "let go of the jog key";
  }
  return "";
}

}  // namespace

const char* ScanStateText(ScanState state) {
  constexpr std::array<const char*, kScanStates> kTexts{"SAFE",     "IDLE",     "HOMING", "ARMED",
                                                        "SCANNING", "STOPPING", "FAULT",  "JOG"};
  return kTexts.at(static_cast<std::size_t>(state));
}

const char* ScanEventText(ScanEventKind kind) {
  constexpr std::array<const char*, kScanEventKinds> kTexts{
      "chain opened", "reset taken",  "home ordered", "homed",       "homing failed", "armed",
      "started",      "last level",   "cancelled",    "arm expired", "faulted",       "stopped",
      "stop late",    "stop overdue", "acknowledged", "jog ordered", "jog released",  "awoke"};
  return kTexts.at(static_cast<std::size_t>(kind));
}

const char* ScanOrderText(ScanEventKind kind) {
  switch (kind) {
    case Kind::kHomeOrdered:
      return "home the axis";
    case Kind::kArmed:
      return "arm a scan";
    case Kind::kStarted:
      return "start the scan";
    case Kind::kCancelled:
      return "cancel";
    case Kind::kAcknowledged:
      return "acknowledge";
    case Kind::kJogOrdered:
      return "jog the axis";
    default:
      return ScanEventText(kind);
  }
}

bool ScanMachine::Latched() const {
  return std::any_of(causes_.begin(), causes_.end(), [](const ScanCause& cause) { return !EndsWithReset(cause); });
}

void ScanMachine::Enter(ScanState state, std::chrono::nanoseconds time) {
  if (state == state_) return;
  state_ = state;
  since_ = time;
  ++version_;
  if (state == State::kSafe) homed_ = false;
  if (state != State::kStopping) quick_stop_ = false;
}

void ScanMachine::Latch(const ScanCause& cause) {
  if (TraitsOf(cause.code).home_lost) homed_ = false;
  const bool known =
      std::any_of(causes_.begin(), causes_.end(), [&](const ScanCause& one) { return one.code == cause.code; });
  if (!known) causes_.push_back(cause);
}

void ScanMachine::Stop(const ScanEvent& event) {
  const bool has_cause = event.kind == Kind::kFaulted || event.kind == Kind::kHomingFailed;
  Enter(State::kStopping, event.time);
  if (event.kind == Kind::kStopLate) quick_stop_ = true;
  if (has_cause && TraitsOf(event.cause.code).stop == StopPath::kQuickStop) quick_stop_ = true;
}

Status ScanMachine::MayOrder(ScanEventKind kind) const {
  if (OutcomeOf(kind, state_) != Outcome::kRefused) {
    if (kind != Kind::kArmed || homed_) return {};
    return Fail("arm a scan", "the axis is not homed", "home it first");
  }
  return Fail(
      ScanOrderText(kind),
      std::string("the booth is ") + ScanStateText(state_) + (causes_.empty() ? "" : ": " + causes_.front().text),
      WayOn(state_));
}

Status ScanMachine::Handle(const ScanEvent& event) {
  Outcome outcome = OutcomeOf(event.kind, state_);
  if (outcome == Outcome::kNothing) return {};
  RETURN_IF_ERROR(MayOrder(event.kind));
  // Whoever notices first that the chain is open: it is the chain that demands it, and a reset that ends it.
  const bool fails = event.kind == Kind::kFaulted || event.kind == Kind::kHomingFailed;
  if (fails && event.cause.code == CauseCode::kChainOpen) outcome = Outcome::kSafe;
  switch (event.kind) {
    case Kind::kStarted:
      if (event.version != version_) {
        return Fail("start the scan", "the booth has changed since the order was given", "look, then start again");
      }
      longest_ = event.longest;
      ++scans_;
      break;
    case Kind::kAcknowledged:
      for (const ScanCause& cause : causes_) {
        if (TraitsOf(cause.code).role == CauseRole::kService && event.role != CauseRole::kService) {
          return Fail("acknowledge the fault", cause.text, "call service: " + cause.advice);
        }
      }
      causes_.clear();
      break;
    case Kind::kResetTaken:
      std::erase_if(causes_, [](const ScanCause& cause) { return EndsWithReset(cause); });
      break;
    case Kind::kHomeOrdered:
      homed_ = false;  // the drive gives up its old reference at the switch; a homing that is broken off has none
      break;
    case Kind::kHomed:
      homed_ = true;
      break;
    case Kind::kArmed:
      since_ = event.time;
      if (state_ == State::kArmed) ++version_;  // perhaps another plan: a start for the former one is refused
      break;
    case Kind::kJogOrdered:
      jog_beat_ = event.time;
      break;
    case Kind::kChainOpened:
    case Kind::kFaulted:
    case Kind::kHomingFailed:
    case Kind::kStopOverdue:
      Latch(event.cause);
      break;
    case Kind::kAwoke:
      if (event.cause.code != CauseCode::kInternal) Latch(event.cause);
      break;
    default:
      break;
  }
  State next = StateOf(outcome);
  if (next == State::kStopping) {
    Stop(event);
    return {};
  }
  if ((event.kind == Kind::kResetTaken || event.kind == Kind::kStopped) && Latched()) next = State::kFault;
  Enter(next, event.time);
  return {};
}

std::optional<ScanEvent> ScanMachine::Due(std::chrono::nanoseconds now) const {
  const auto lasted = now - since_;
  ScanEvent event;
  event.time = now;
  switch (state_) {
    case State::kHoming:
      if (lasted < scan_time::kHomingFor) return std::nullopt;
      event.kind = Kind::kHomingFailed;
      event.cause = {CauseCode::kHoming, "the axis was not homed in time", "check the home switch and its wire", now};
      return event;
    case State::kArmed:
      if (lasted < scan_time::kArmedFor) return std::nullopt;
      event.kind = Kind::kArmExpired;
      return event;
    case State::kScanning:
      if (lasted < longest_) return std::nullopt;
      event.kind = Kind::kFaulted;
      event.cause = {CauseCode::kInternal, "the scan takes longer than it can", "report this; home the axis again",
                     now};
      return event;
    case State::kStopping:
      if (lasted >= scan_time::kStopOverdueAfter) {
        event.kind = Kind::kStopOverdue;
        event.cause = {CauseCode::kStopOverdue, "the axis was not at rest, disabled and braked 0.5 s after its stop",
                       "look for an obstacle and check drive and brake; then home again", now};
        return event;
      }
      if (lasted < scan_time::kStopLateAfter || quick_stop_) return std::nullopt;
      event.kind = Kind::kStopLate;
      return event;
    case State::kJog:
      if (now - jog_beat_ < scan_time::kJogBeat) return std::nullopt;
      event.kind = Kind::kJogReleased;
      return event;
    case State::kSafe:
    case State::kIdle:
    case State::kFault:
      return std::nullopt;  // they wait for people
  }
  return std::nullopt;
}

LineOrders ScanMachine::Lines() const {
  LineOrders lines;
  const bool moving = may_move();
  lines.enable = moving || state_ == State::kStopping;
  lines.quick_stop = moving || (state_ == State::kStopping && !quick_stop_);
  lines.emitters = state_ == State::kScanning;
  lines.lamp_ready = state_ == State::kIdle || state_ == State::kArmed;
  lines.lamp_running = moving || state_ == State::kStopping;
  lines.lamp_fault = state_ == State::kFault || Latched();
  return lines;
}

}  // namespace annulus
