#include "tests/faults/invariant_watch.h"

#include <algorithm>
#include <cmath>

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kMostViolations = 20;
/// An order that was sent just before a state ended is still on its way, and valid for the drive's start window.
constexpr milliseconds kOnTheWire{30};
constexpr milliseconds kOldestSetPoint{100};
/// What a tick that is late, or a wait for the next one, may add to a deadline.
constexpr milliseconds kTickSlack{25};
/// From an open chain to the drive's quick-stop input: two relays of 15 ms, and room.
constexpr milliseconds kRelays{40};
constexpr double kAtRestMmS = 0.01;
/// Of the software limits, within the buffers.
constexpr double kOvertravelMm = 20.0;

std::string At(nanoseconds time) { return " at " + std::to_string(time / milliseconds(1)) + " ms"; }

}  // namespace

bool InvariantWatch::Moves(ScanState state) {
  return state == ScanState::kHoming || state == ScanState::kScanning || state == ScanState::kJog;
}

void InvariantWatch::Violated(const std::string& what) {
  if (violations_.size() < kMostViolations) violations_.push_back(what + At(clock_.Now()));
}

std::string InvariantWatch::Text() const {
  std::string text;
  for (const std::string& one : violations_) text += "\n  " + one;
  text += "\n  states:";
  for (const StateAt& one : states_)
    text += " " + std::string(ScanStateText(one.state)) + "@" + std::to_string(one.time / milliseconds(1));
  return text;
}

void InvariantWatch::Watch(const Scanner* scanner) {
  scanner_ = scanner;
  first_cause_.reset();
  reset_pressed_ = acknowledged_ = ordered_ = false;
  starts_ = scans_ = 0;
  last_tick_ = entered_ = last_answer_ = clock_.Now();
  if (scanner == nullptr) return;
  const ScannerStatus status = scanner->status();
  state_ = status.state;
  version_ = status.version;
  states_.push_back({clock_.Now(), state_});
  if (state_ != ScanState::kSafe) Violated("the program begins in " + std::string(ScanStateText(state_)));
}

void InvariantWatch::Note(HumanAct act) {
  Look();
  switch (act) {
    case HumanAct::kReset:
      reset_pressed_ = true;
      return;
    case HumanAct::kAcknowledge:
      acknowledged_ = true;
      return;
    case HumanAct::kStart:
      ++starts_;
      break;
    case HumanAct::kJog:
      last_jog_ = clock_.Now();
      break;
    case HumanAct::kHome:
      break;
  }
  ordered_ = true;
}

std::optional<nanoseconds> InvariantWatch::When(ScanState state, nanoseconds time) const {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const bool over = i + 1 < states_.size() && states_[i + 1].time <= time;
    if (states_[i].state == state && !over) return std::max(time, states_[i].time);
  }
  return std::nullopt;
}

ScanState InvariantWatch::StateBefore(nanoseconds time) const {
  ScanState state = ScanState::kSafe;
  for (const StateAt& one : states_) {
    if (one.time < time) state = one.state;
  }
  return state;
}

void InvariantWatch::Look() {
  if (scanner_ == nullptr) return;
  const ScannerStatus status = scanner_->status();
  JudgeMotion();
  if (status.state != state_) OnChange(state_, status);
  JudgeCauses(status);
  if (Moves(state_)) moved_until_ = clock_.Now();
  if (state_ == ScanState::kIdle || state_ == ScanState::kSafe || state_ == ScanState::kFault) {
    if (clock_.Now() - moved_until_ > kOnTheWire && status.job.empty()) ordered_ = false;
  }
}

void InvariantWatch::OnChange(ScanState from, const ScannerStatus& status) {
  const ScanState to = status.state;
  const nanoseconds now = clock_.Now();
  if (from == ScanState::kSafe) {
    if (!reset_pressed_) Violated("I3: SAFE was left without a reset");
    if (Moves(to) || to == ScanState::kArmed) Violated("I3: SAFE was left for " + std::string(ScanStateText(to)));
    reset_pressed_ = false;
    first_cause_.reset();  // demands of the chain end with the reset
  }
  if (from == ScanState::kFault && to != ScanState::kSafe) {
    if (!acknowledged_) Violated("I3: FAULT was left without an acknowledgement");
    if (to != ScanState::kIdle) Violated("I3: FAULT was left for " + std::string(ScanStateText(to)));
    first_cause_.reset();
  }
  if (from == ScanState::kFault) acknowledged_ = false;
  if (to == ScanState::kScanning && ++scans_ > starts_) Violated("I5: more scans than starts");
  if (Moves(to) && !ordered_) Violated("I9: " + std::string(ScanStateText(to)) + " without an order");
  if (Moves(to) && from != ScanState::kIdle && from != ScanState::kArmed) {
    Violated("I3: from " + std::string(ScanStateText(from)) + " to " + ScanStateText(to));
  }
  state_ = to;
  entered_ = now;
  states_.push_back({now, to});
}

void InvariantWatch::JudgeMotion() {
  const auto& log = booth_.drive().motion_log();
  for (; motions_ < log.size(); ++motions_) {
    const nanoseconds time = log[motions_];
    if (!Moves(state_) && time - moved_until_ > kOnTheWire) {
      Violated("I1: motion in " + std::string(ScanStateText(state_)) + ", begun" + At(time));
    }
    if (!ordered_) Violated("I9: motion without an order, begun" + At(time));
    if (time - last_answer_ > kOldestSetPoint) Violated("I4: motion from a place that is too old, begun" + At(time));
  }
}

void InvariantWatch::JudgeCauses(const ScannerStatus& status) {
  if (status.causes.empty()) {
    first_cause_.reset();
    return;
  }
  const ScanCause& first = status.causes.front();
  if (first_cause_ && first.code != *first_cause_) {
    Violated(std::string("I6: the first cause was ") + TraitsOf(*first_cause_).name + " and is " +
             TraitsOf(first.code).name);
  }
  if (!first_cause_) shown_.push_back(first);
  first_cause_ = first.code;
  for (const ScanCause& cause : status.causes) {
    if (cause.text.empty() || cause.advice.empty()) {
      Violated(std::string("R0: a cause without text or advice: ") + TraitsOf(cause.code).name);
    }
  }
}

void InvariantWatch::JudgeDeadline() {
  const nanoseconds now = clock_.Now();
  const auto limit = [&]() -> std::optional<nanoseconds> {
    switch (state_) {
      case ScanState::kHoming:
        return scan_time::kHomingFor;
      case ScanState::kArmed:
        return scan_time::kArmedFor;
      case ScanState::kScanning:
        return std::chrono::minutes(5);
      case ScanState::kStopping:
        return scan_time::kStopOverdueAfter;
      default:
        return std::nullopt;
    }
  }();
  if (limit && now - entered_ > *limit + kTickSlack) {
    Violated("I7: " + std::string(ScanStateText(state_)) + " outlasts its deadline");
    entered_ = now;
  }
  if (state_ == ScanState::kJog && now - std::max(last_jog_, entered_) > scan_time::kJogBeat + kTickSlack) {
    Violated("I7: JOG goes on without a beat");
    last_jog_ = now;
  }
}

void InvariantWatch::JudgePlace() {
  sim::AxisDriveModel& drive = booth_.drive();
  const nanoseconds now = clock_.Now();
  const AxisLimits& limits = drive.options().limits;
  const double z = drive.TrueZ(now);
  if (z < limits.z_min.value() - kOvertravelMm || z > limits.z_max.value() + kOvertravelMm) {
    Violated("R0: the carriage is out of its travel: " + std::to_string(z) + " mm");
  }
  if (std::abs(drive.TrueSpeed(now)) > kAtRestMmS || booth_.safety().Level(sim::ChainSignal::kBrakeReleased)) {
    unsafe_until_ = now;
  }
}

void InvariantWatch::AfterTick() {
  Look();
  JudgePlace();
  JudgeDeadline();
  const nanoseconds now = clock_.Now();
  sim::SafetyChain& chain = booth_.safety();
  if (chain.WasOpen(last_tick_, now)) {
    for (const InterlockOutput output :
         {InterlockOutput::kEnable, InterlockOutput::kQuickStop, InterlockOutput::kEmitters}) {
      if (chain.Pin(output) && lines_taken_) {
        Violated(std::string("I2: the chain is open and this is on: ") + InterlockName(output));
      }
    }
  }
  // Orders that the chip refuses are given again and again; meanwhile it is the chain that stops the drive.
  if (!lines_taken_ && chain.WasOpen(now - kRelays - milliseconds(10), now - kRelays) &&
      chain.Level(sim::ChainSignal::kQuickStopInput)) {
    Violated("I2: the chain is open, the chip refuses orders, and the drive may run");
  }
  last_tick_ = now;
}

}  // namespace annulus::faults
