#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "acquisition/scan_machine.h"

namespace annulus::test {

struct CauseMark {
  CauseCode code = CauseCode::kInternal;
  std::chrono::nanoseconds time{0};

  bool operator==(const CauseMark&) const = default;
};

/// Latched causes in their order, without their texts.
struct CauseMarks {
  std::array<CauseMark, kCauseCodes> marks{};
  std::size_t count = 0;

  void Note(CauseCode code, std::chrono::nanoseconds time) {
    const auto end = marks.begin() + static_cast<std::ptrdiff_t>(count);
    if (std::any_of(marks.begin(), end, [code](const CauseMark& mark) { return mark.code == code; })) return;
    marks.at(count++) = {code, time};
  }
  void Forget(CauseCode code) {
    const auto end = marks.begin() + static_cast<std::ptrdiff_t>(count);
    count = static_cast<std::size_t>(
        std::remove_if(marks.begin(), end, [code](const CauseMark& mark) { return mark.code == code; }) -
        marks.begin());
  }
  /// Whether a person has to acknowledge something.
  [[nodiscard]] bool Latched() const {
    const auto end = marks.begin() + static_cast<std::ptrdiff_t>(count);
    return std::any_of(marks.begin(), end, [](const CauseMark& mark) { return mark.code != CauseCode::kChainOpen; });
  }
  /// Whether one of them is for service only: E3, E11, A3.
  [[nodiscard]] bool ForService() const {
    const auto end = marks.begin() + static_cast<std::ptrdiff_t>(count);
    return std::any_of(marks.begin(), end, [](const CauseMark& mark) {
      return mark.code == CauseCode::kChannelsDiffer || mark.code == CauseCode::kWeldedContact ||
             mark.code == CauseCode::kBrakeSlip;
    });
  }
  bool operator==(const CauseMarks& other) const {
    return count == other.count &&
           std::equal(marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(count), other.marks.begin());
  }
};

/// All that can be seen of a machine.
struct MachineView {
  ScanState state = ScanState::kSafe;
  std::uint64_t version = 0;
  bool homed = false;
  bool quick_stop = false;
  bool may_move = false;
  LineOrders lines;
  std::uint64_t scans = 0;
  std::chrono::nanoseconds since{0};
  CauseMarks causes;

  bool operator==(const MachineView&) const = default;
};

inline MachineView LookAt(const ScanMachine& machine) {
  MachineView view{machine.state(),
                   machine.version(),
                   machine.homed(),
                   machine.quick_stop_demanded(),
                   machine.may_move(),
                   machine.Lines(),
                   machine.scans(),
                   machine.since(),
                   {}};
  for (const ScanCause& cause : machine.causes()) view.causes.marks.at(view.causes.count++) = {cause.code, cause.time};
  return view;
}

/// Holds a machine to what it promises (I1, I2, I3, I5, I6, I7, and the rules of stops, versions and causes) from what
/// happened to it and what can be seen of it. Knows neither the machine's table nor its predicates: each rule is stated
/// anew, from the requirement. Every call says which rule is broken, or null.
class ScanMachineChecker {
 public:
  using Nanoseconds = std::chrono::nanoseconds;

  explicit ScanMachineChecker(const MachineView& view) : before_(view) {}

  /// After an event was handled.
  const char* AfterEvent(const ScanEvent& event, bool refused, const MachineView& after) {
    if (refused) return Refused(event, after);
    if (const char* broken = Memory(event, after)) return broken;
    const bool changed = after.state != before_.state;
    const char* broken = changed ? Arrival(event, after) : nullptr;
    if (broken == nullptr) broken = Consequence(event, after);
    if (broken == nullptr) broken = Flags(event, after);
    if (broken == nullptr) broken = Standing(after);
    SetDeadline(event, after);
    before_ = after;
    return broken;
  }

  /// After it was asked what is due: the states that may not last have a deadline, kept to the nanosecond (I7).
  [[nodiscard]] const char* AfterDue(const std::optional<ScanEvent>& due, Nanoseconds now) const {
    const bool late = deadline_ && now >= *deadline_;
    const bool stop_late = stop_late_ && now >= *stop_late_ && !before_.quick_stop;
    if (due.has_value() != (late || stop_late)) return due ? "due before its time" : "I7: nothing is due at a deadline";
    if (!due) return nullptr;
    const ScanEventKind kind = due->kind;
    switch (before_.state) {
      case ScanState::kHoming:
        return kind == ScanEventKind::kHomingFailed ? nullptr : "homing ends otherwise than by having failed";
      case ScanState::kArmed:
        return kind == ScanEventKind::kArmExpired ? nullptr : "arming ends otherwise than by having expired";
      case ScanState::kScanning:
        return kind == ScanEventKind::kFaulted ? nullptr : "an endless scan is not a fault";
      case ScanState::kJog:
        return kind == ScanEventKind::kJogReleased ? nullptr : "a jog without a beat is not a released one";
      case ScanState::kStopping:
        return kind == (late ? ScanEventKind::kStopOverdue : ScanEventKind::kStopLate) ? nullptr : "wrong escalation";
      default:
        return "something is due where people are waited for";
    }
  }

  /// A beat of the jog.
  void Beat(Nanoseconds now) {
    if (before_.state == ScanState::kJog) deadline_ = now + std::chrono::milliseconds(100);
  }

  [[nodiscard]] const MachineView& view() const { return before_; }
  [[nodiscard]] bool chain_open() const { return chain_open_; }
  /// When this state must be over; none while people are waited for.
  [[nodiscard]] std::optional<Nanoseconds> deadline() const { return deadline_; }

 private:
  using State = ScanState;
  using Kind = ScanEventKind;

  static bool Moves(State state) {
    return state == State::kHoming || state == State::kScanning || state == State::kJog;
  }

  /// Whether an event is a reason to stop what is going on.
  static bool MayStop(State state, Kind kind) {
    const bool ends = (state == State::kHoming && kind == Kind::kHomingFailed) ||
                      (state == State::kScanning && kind == Kind::kLastLevel) ||
                      (state == State::kJog && kind == Kind::kJogReleased);
    return ends || (Moves(state) && (kind == Kind::kFaulted || kind == Kind::kCancelled));
  }

  /// What was refused has changed nothing, and only orders may be refused: what has happened has happened.
  const char* Refused(const ScanEvent& event, const MachineView& after) const {
    const bool order = event.kind == Kind::kHomeOrdered || event.kind == Kind::kArmed || event.kind == Kind::kStarted ||
                       event.kind == Kind::kAcknowledged || event.kind == Kind::kJogOrdered;
    if (!order) return "an event that is no order was refused";
    if (!(after == before_)) return "a refused order has changed something";
    if (event.kind == Kind::kStarted && before_.state == State::kArmed && event.version == before_.version)
      return "a good start was refused";
    if (event.kind == Kind::kArmed && before_.homed &&
        (before_.state == State::kIdle || before_.state == State::kArmed))
      return "arming was refused though idle and homed";
    if ((event.kind == Kind::kHomeOrdered || event.kind == Kind::kJogOrdered) && before_.state == State::kIdle)
      return "homing or jogging was refused in idle";
    if (event.kind == Kind::kJogOrdered && before_.state == State::kJog) return "a jog may not go on";
    const bool may = event.role == CauseRole::kService || !before_.causes.ForService();
    if (event.kind == Kind::kAcknowledged && before_.state == State::kFault && may)
      return "an acknowledgement was refused to somebody who may";
    return nullptr;
  }

  /// The causes are those that were told, the first one first (I6); the chain is open from its demand to the reset.
  const char* Memory(const ScanEvent& event, const MachineView& after) {
    CauseMarks expected = before_.causes;
    const bool told = event.kind == Kind::kChainOpened || event.kind == Kind::kFaulted ||
                      (event.kind == Kind::kHomingFailed && before_.state == State::kHoming) ||
                      (event.kind == Kind::kStopOverdue && before_.state == State::kStopping) ||
                      (event.kind == Kind::kAwoke && event.cause.code != CauseCode::kInternal);
    if (told) expected.Note(event.cause.code, event.cause.time);
    if (event.kind == Kind::kChainOpened || (told && event.cause.code == CauseCode::kChainOpen)) chain_open_ = true;
    if (event.kind == Kind::kResetTaken && before_.state == State::kSafe) {
      expected.Forget(CauseCode::kChainOpen);
      chain_open_ = false;
    }
    if (event.kind == Kind::kAcknowledged) {
      if (before_.causes.ForService() && event.role != CauseRole::kService)
        return "E3, E11, A3: service was not needed";
      expected.count = 0;
    }
    told_ = told;
    return after.causes == expected ? nullptr : "I6: the causes are not those that were told, in their order";
  }

  /// A state is only come to from where, and by what, it may be.
  const char* Arrival(const ScanEvent& event, const MachineView& after) const {
    const State from = before_.state;
    const Kind by = event.kind;
    const bool latched = after.causes.Latched();
    switch (after.state) {
      case State::kSafe:
        if (by == Kind::kChainOpened || by == Kind::kAwoke) return nullptr;
        if (by == Kind::kStopOverdue && from == State::kStopping) return nullptr;
        return told_ && event.cause.code == CauseCode::kChainOpen ? nullptr : "SAFE without a reason";
      case State::kIdle:
        if (latched) return "I3: idle with a latched cause";
        if (from == State::kSafe) return by == Kind::kResetTaken ? nullptr : "I3: SAFE left without a reset";
        if (from == State::kFault) return by == Kind::kAcknowledged ? nullptr : "I3: FAULT left without a person";
        if (from == State::kHoming)
          return by == Kind::kHomed ? nullptr : "homing ended without home and without a stop";
        if (from == State::kArmed)
          return by == Kind::kCancelled || by == Kind::kArmExpired ? nullptr : "disarmed for nothing";
        return from == State::kStopping && by == Kind::kStopped ? nullptr : "idle though it may still move";
      case State::kFault:
        if (!latched) return "FAULT without a cause";
        if (from == State::kSafe) return by == Kind::kResetTaken ? nullptr : "I3: SAFE left without a reset";
        if (from == State::kIdle || from == State::kArmed) return by == Kind::kFaulted ? nullptr : "FAULT for nothing";
        return from == State::kStopping && by == Kind::kStopped ? nullptr : "FAULT though it may still move";
      case State::kStopping:
        return MayStop(from, by) ? nullptr : "stopped for nothing, or what does not move";
      case State::kHoming:
        return from == State::kIdle && by == Kind::kHomeOrdered ? nullptr : "I1: homes without an order in idle";
      case State::kJog:
        return from == State::kIdle && by == Kind::kJogOrdered ? nullptr : "I1: jogs without an order in idle";
      case State::kArmed:
        return from == State::kIdle && by == Kind::kArmed ? nullptr : "armed without an order in idle";
      case State::kScanning:
        if (from != State::kArmed || by != Kind::kStarted) return "I1, I5: scans without a start of what was armed";
        return event.version == before_.version ? nullptr : "N3: a start for an older version was taken";
    }
    return "no such state";
  }

  static const char* Carried(bool out) { return out ? nullptr : "an order that was neither refused nor carried out"; }

  /// What must follow from an event that was taken.
  const char* Consequence(const ScanEvent& event, const MachineView& after) const {
    const State from = before_.state;
    const State to = after.state;
    switch (event.kind) {
      case Kind::kChainOpened:
      case Kind::kAwoke:
        return to == State::kSafe ? nullptr : "I2: not SAFE though the chain is open, or after it woke";
      case Kind::kFaulted:
        return to == State::kSafe || to == State::kFault || to == State::kStopping ? nullptr : "a fault had no effect";
      case Kind::kCancelled:
        return Moves(to) || to == State::kArmed ? "U3: cancelled, and goes on" : nullptr;
      case Kind::kHomingFailed:
      case Kind::kHomed:
        return to == State::kHoming ? "homing is over, and goes on" : nullptr;
      case Kind::kLastLevel:
        return to == State::kScanning ? "the scan is over, and goes on" : nullptr;
      case Kind::kJogReleased:
        return to == State::kJog ? "the jog is over, and goes on" : nullptr;
      case Kind::kArmExpired:
        return to == State::kArmed ? "armed for longer than allowed" : nullptr;
      case Kind::kStopped:
      case Kind::kStopOverdue:
        return to == State::kStopping ? "the stop is over, and goes on" : nullptr;
      case Kind::kStopLate:
        return to == State::kStopping && !after.quick_stop ? "a late stop does not demand the quick-stop line"
                                                           : nullptr;
      case Kind::kResetTaken:
        return from == State::kSafe && to == State::kSafe ? "a reset without effect" : nullptr;
      case Kind::kHomeOrdered:
        return Carried(from == State::kIdle && to == State::kHoming);
      case Kind::kArmed:
        return Carried((from == State::kIdle || from == State::kArmed) && to == State::kArmed);
      case Kind::kStarted:
        return Carried(from == State::kArmed && to == State::kScanning);
      case Kind::kAcknowledged:
        return Carried(from == State::kFault && to == State::kIdle);
      case Kind::kJogOrdered:
        return Carried((from == State::kIdle || from == State::kJog) && to == State::kJog);
    }
    return "no such event";
  }

  /// Version, scans, home and the quick stop change when, and only when, they must.
  const char* Flags(const ScanEvent& event, const MachineView& after) const {
    const bool entered = after.state != before_.state || event.kind == Kind::kArmed;
    if (after.version < before_.version) return "the version fell";
    if ((after.version > before_.version) != entered) return "the version rose without a change, or did not with one";
    if (entered && after.since != event.time) return "the state's begin is wrong";
    const bool started = before_.state != State::kScanning && after.state == State::kScanning;
    if (after.scans != before_.scans + (started ? 1 : 0)) return "I5: not one scan for one start";

    const bool found = event.kind == Kind::kHomed && before_.state == State::kHoming;
    if (found && !after.homed) return "not homed though home was found";
    if (after.homed && !before_.homed && !found) return "homed without homing";
    const CauseCode code = event.cause.code;
    if (told_ && after.homed &&
        (code == CauseCode::kAxisLink || code == CauseCode::kEncoderJump || code == CauseCode::kAxisFault))
      return "homed though link, encoder or drive failed";
    if (before_.homed && !after.homed && !told_ && after.state != State::kSafe && after.state != State::kHoming)
      return "home was lost for nothing";

    if (after.state != State::kStopping) return nullptr;
    const bool demands = (told_ && TraitsOf(code).stop == StopPath::kQuickStop) || event.kind == Kind::kStopLate;
    const bool stayed = before_.state == State::kStopping && before_.quick_stop;
    return after.quick_stop == (demands || stayed) ? nullptr : "the quick-stop line is not demanded as the cause says";
  }

  /// What holds in a state, however it was come to.
  const char* Standing(const MachineView& view) const {
    const State state = view.state;
    const bool moves = Moves(state);
    const bool stops = state == State::kStopping;
    if (view.may_move != moves) return "I1: may move where it may not";
    if (chain_open_ && (state != State::kSafe || view.lines.enable || view.lines.quick_stop || view.lines.emitters))
      return "I2: an output is on though the chain is open";
    if (view.lines.enable != (moves || stops)) return "enable where nothing moves, or none where something does";
    if (view.lines.quick_stop != (moves || (stops && !view.quick_stop))) return "the quick-stop line is wrong";
    if (view.lines.emitters != (state == State::kScanning)) return "emitters outside a scan";
    if (view.lines.lamp_running != (moves || stops)) return "the running lamp is wrong";
    if (view.lines.lamp_ready != (state == State::kIdle || state == State::kArmed)) return "the ready lamp is wrong";
    if (view.lines.lamp_fault != view.causes.Latched()) return "the fault lamp is wrong";
    if (view.quick_stop && !stops) return "a quick stop outlives its stop";
    const bool waits = state == State::kSafe || state == State::kFault || stops;
    if (!waits && view.causes.count != 0) return "in operation with a cause";
    if (state == State::kFault && !view.causes.Latched()) return "FAULT without a cause";
    if ((state == State::kSafe || state == State::kHoming) && view.homed) return "homed in SAFE or while homing";
    if ((state == State::kArmed || state == State::kScanning) && !view.homed) return "armed though not homed";
    return nullptr;
  }

  /// The requirement's times.
  void SetDeadline(const ScanEvent& event, const MachineView& after) {
    using std::chrono::milliseconds;
    using std::chrono::seconds;
    const bool again = event.kind == Kind::kArmed || event.kind == Kind::kJogOrdered;
    if (after.state == before_.state && !again) return;
    deadline_.reset();
    stop_late_.reset();
    if (after.state == State::kHoming) deadline_ = event.time + seconds(95);
    if (after.state == State::kArmed) deadline_ = event.time + seconds(60);
    if (after.state == State::kScanning) deadline_ = event.time + event.longest;
    if (after.state == State::kJog) deadline_ = event.time + milliseconds(100);
    if (after.state != State::kStopping) return;
    deadline_ = event.time + milliseconds(500);
    stop_late_ = event.time + milliseconds(300);
  }

  MachineView before_;
  bool chain_open_ = false;
  bool told_ = false;  ///< The event has put down a cause.
  std::optional<Nanoseconds> deadline_;
  std::optional<Nanoseconds> stop_late_;
};

}  // namespace annulus::test
