// What the checker of tests/support can see: machines with one planted defect each, all of which it must catch.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/acquisition/scan_machine_table.h"
#include "tests/acquisition/scan_machine_walk.h"
#include "tests/support/scan_machine_session.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::LookAt;
using test::MachineSession;
using test::MachineView;
using Kind = ScanEventKind;
using State = ScanState;

/// How a machine goes wrong: in what it does, in what it says is due, or in what is seen of it. Empty: as it should.
struct Defect {
  std::string name;
  std::function<Status(ScanMachine&, ScanEvent)> handle;
  std::function<std::optional<ScanEvent>(const ScanMachine&, nanoseconds)> due;
  std::function<void(MachineView& view, const MachineView& before)> look;
};

/// A machine with a defect.
class DefectiveMachine {
 public:
  explicit DefectiveMachine(const Defect& defect) : defect_(&defect), seen_(LookAt(machine_)) {}

  Status Handle(const ScanEvent& event) {
    Status status = defect_->handle ? defect_->handle(machine_, event) : machine_.Handle(event);
    MachineView view = LookAt(machine_);
    if (defect_->look) defect_->look(view, seen_);
    seen_ = view;
    return status;
  }
  [[nodiscard]] std::optional<ScanEvent> Due(nanoseconds now) const {
    return defect_->due ? defect_->due(machine_, now) : machine_.Due(now);
  }
  void JogBeat(nanoseconds now) { machine_.JogBeat(now); }
  [[nodiscard]] const MachineView& seen() const { return seen_; }

 private:
  const Defect* defect_;
  ScanMachine machine_;
  MachineView seen_;
};

MachineView LookAt(const DefectiveMachine& machine) { return machine.seen(); }

/// The rule that catches it, or null.
const char* Caught(const Defect& defect) {
  MachineSession<DefectiveMachine> session{DefectiveMachine(defect)};
  return test::Walk(session, 300'000, 7);
}

/// An event in a state is taken for another one: what a wrong cell of the table does.
Defect TakenFor(State state, Kind kind, Kind other) {
  Defect defect;
  defect.name =
      std::string(ScanStateText(state)) + ": '" + ScanEventText(kind) + "' taken for '" + ScanEventText(other) + "'";
  defect.handle = [=](ScanMachine& machine, ScanEvent event) {
    if (machine.state() == state && event.kind == kind) event.kind = other;
    return machine.Handle(event);
  };
  return defect;
}

/// An event in a state is not noticed.
Defect Ignored(State state, Kind kind) {
  Defect defect;
  defect.name = std::string(ScanStateText(state)) + ": '" + ScanEventText(kind) + "' ignored";
  defect.handle = [=](ScanMachine& machine, const ScanEvent& event) {
    return machine.state() == state && event.kind == kind ? Status{} : machine.Handle(event);
  };
  return defect;
}

TEST(ScanMachineDefects, EveryEventTakenForAnotherIsCaught) {
  const test::DrawnTable table;
  // Two events that are to do the same in a state cannot be told apart there.
  const std::set<std::tuple<State, Kind, Kind>> same{{State::kSafe, Kind::kChainOpened, Kind::kFaulted},
                                                     {State::kSafe, Kind::kFaulted, Kind::kChainOpened},
                                                     {State::kStopping, Kind::kChainOpened, Kind::kStopOverdue},
                                                     {State::kStopping, Kind::kStopOverdue, Kind::kChainOpened},
                                                     {State::kHoming, Kind::kHomingFailed, Kind::kFaulted},
                                                     {State::kHoming, Kind::kFaulted, Kind::kHomingFailed},
                                                     {State::kArmed, Kind::kCancelled, Kind::kArmExpired},
                                                     {State::kArmed, Kind::kArmExpired, Kind::kCancelled},
                                                     {State::kScanning, Kind::kCancelled, Kind::kLastLevel},
                                                     {State::kScanning, Kind::kLastLevel, Kind::kCancelled},
                                                     {State::kJog, Kind::kCancelled, Kind::kJogReleased},
                                                     {State::kJog, Kind::kJogReleased, Kind::kCancelled}};
  std::size_t planted = 0;
  std::size_t caught = 0;
  for (std::size_t s = 0; s < kScanStates; ++s) {
    for (std::size_t k = 0; k < kScanEventKinds; ++k) {
      const auto state = static_cast<State>(s);
      const auto kind = static_cast<Kind>(k);
      const std::string& cell = table.At(state, kind);
      std::vector<Defect> defects;
      if (cell != "-") defects.push_back(Ignored(state, kind));
      for (std::size_t o = 0; o < kScanEventKinds; ++o) {
        const auto other = static_cast<Kind>(o);
        const bool nothing = cell == table.At(state, other) && (cell == "-" || cell == "no");
        if (o != k && !nothing && !same.contains({state, kind, other})) defects.push_back(TakenFor(state, kind, other));
      }
      for (const Defect& defect : defects) {
        const bool seen = Caught(defect) != nullptr;
        ++planted;
        caught += seen ? 1 : 0;
        EXPECT_TRUE(seen) << defect.name;
      }
    }
  }
  std::printf("events taken for others: %zu of %zu defects caught\n", caught, planted);
}

/// Does `change` to the event before it is handled.
Defect Before(std::string name, std::function<void(const ScanMachine&, ScanEvent&)> change) {
  Defect defect;
  defect.name = std::move(name);
  defect.handle = [change = std::move(change)](ScanMachine& machine, ScanEvent event) {
    change(machine, event);
    return machine.Handle(event);
  };
  return defect;
}

/// Another event follows by itself.
Defect Then(std::string name, Kind kind, Kind next) {
  Defect defect;
  defect.name = std::move(name);
  defect.handle = [=](ScanMachine& machine, ScanEvent event) {
    Status status = machine.Handle(event);
    if (event.kind != kind || !status) return status;
    event.kind = next;
    event.version = machine.version();
    static_cast<void>(machine.Handle(event));
    return status;
  };
  return defect;
}

/// The deadline of a state comes so much later; never, if it is very long.
Defect Late(std::string name, State state, nanoseconds delay) {
  Defect defect;
  defect.name = std::move(name);
  defect.due = [=](const ScanMachine& machine, nanoseconds now) {
    return machine.Due(machine.state() == state ? now - delay : now);
  };
  return defect;
}

/// What is seen is changed.
Defect Look(std::string name, std::function<void(MachineView&, const MachineView&)> look) {
  Defect defect;
  defect.name = std::move(name);
  defect.look = std::move(look);
  return defect;
}

std::vector<Defect> DefectsOfOrders() {
  return {
      Before("a start for any version is taken",
             [](const ScanMachine& machine, ScanEvent& event) { event.version = machine.version(); }),
      Before("anybody may acknowledge", [](const ScanMachine&, ScanEvent& event) { event.role = CauseRole::kService; }),
      Before("nobody but service may acknowledge",
             [](const ScanMachine& machine, ScanEvent& event) {
               if (event.kind == Kind::kAcknowledged && event.role == CauseRole::kOperator)
                 event.kind = machine.state() == State::kFault ? Kind::kHomeOrdered : event.kind;
             }),
      Before("a scan may last for ever",
             [](const ScanMachine&, ScanEvent& event) { event.longest = std::chrono::hours(100); }),
      Before("every fault ramps",
             [](const ScanMachine&, ScanEvent& event) {
               if (event.kind == Kind::kFaulted) event.cause.code = CauseCode::kSensorLost;
             }),
      Then("a reset homes", Kind::kResetTaken, Kind::kHomeOrdered),
      Then("an acknowledgement homes", Kind::kAcknowledged, Kind::kHomeOrdered),
      Then("arming starts", Kind::kArmed, Kind::kStarted),
      Then("an opened chain resets itself", Kind::kChainOpened, Kind::kResetTaken),
      Then("a stop that was demanded counts as reached", Kind::kCancelled, Kind::kStopped),
      Then("a reset acknowledges", Kind::kResetTaken, Kind::kAcknowledged),
  };
}

std::vector<Defect> DefectsOfTime() {
  return {
      Late("homing without a deadline", State::kHoming, std::chrono::hours(1000)),
      Late("homing ends a nanosecond late", State::kHoming, nanoseconds(1)),
      Late("armed without a deadline", State::kArmed, std::chrono::hours(1000)),
      Late("armed for 61 s", State::kArmed, std::chrono::seconds(1)),
      Late("scanning without a deadline", State::kScanning, std::chrono::hours(1000)),
      Late("stopping without a deadline", State::kStopping, std::chrono::hours(1000)),
      Late("stop late one tick late", State::kStopping, milliseconds(10)),
      Late("jog without a beat", State::kJog, std::chrono::hours(1000)),
      Late("jog that ends before its time", State::kJog, milliseconds(-1)),
      Look("an arming that is made again does not start the time anew",
           [](MachineView& view, const MachineView& before) {
             if (view.state == before.state) view.since = before.since;
           }),
  };
}

std::vector<Defect> DefectsOfMemory() {
  return {
      Look("the last cause is shown first",
           [](MachineView& view, const MachineView&) {
             if (view.causes.count > 1) std::swap(view.causes.marks[0], view.causes.marks[view.causes.count - 1]);
           }),
      Look("a repeated cause replaces the former one",
           [](MachineView& view, const MachineView& before) {
             if (view.causes.count > 0 && view.causes == before.causes) view.causes.marks[0].time += nanoseconds(1);
           }),
      Look("the second cause is lost",
           [](MachineView& view, const MachineView&) {
             view.causes.count = std::min<std::size_t>(view.causes.count, 1);
           }),
      Look("home survives SAFE",
           [](MachineView& view, const MachineView& before) { view.homed = view.homed || before.homed; }),
      Look("a new homing keeps the old home",
           [](MachineView& view, const MachineView& before) {
             if (view.state == State::kHoming) view.homed = before.homed;
           }),
      Look("home is never found", [](MachineView& view, const MachineView&) { view.homed = false; }),
      Look("the version stays", [](MachineView& view, const MachineView&) { view.version = 1; }),
      Look("an arming that is made again keeps the version",
           [](MachineView& view, const MachineView& before) {
             if (view.state == before.state) view.version = before.version;
           }),
      Look("scans are not counted", [](MachineView& view, const MachineView&) { view.scans = 0; }),
  };
}

std::vector<Defect> DefectsOfOutputs() {
  return {
      Look("enable in SAFE",
           [](MachineView& view, const MachineView&) { view.lines.enable |= view.state == State::kSafe; }),
      Look("enable in FAULT",
           [](MachineView& view, const MachineView&) { view.lines.enable |= view.state == State::kFault; }),
      Look("enable while armed",
           [](MachineView& view, const MachineView&) { view.lines.enable |= view.state == State::kArmed; }),
      Look("enable goes at the begin of a stop",
           [](MachineView& view, const MachineView&) { view.lines.enable &= view.state != State::kStopping; }),
      Look("the quick-stop line is never demanded",
           [](MachineView& view, const MachineView&) { view.lines.quick_stop = view.lines.enable; }),
      Look("emitters stay on while it stops",
           [](MachineView& view, const MachineView&) { view.lines.emitters |= view.state == State::kStopping; }),
      Look("the fault lamp is dark in SAFE",
           [](MachineView& view, const MachineView&) { view.lines.lamp_fault &= view.state != State::kSafe; }),
      Look("ready though a fault is latched",
           [](MachineView& view, const MachineView&) { view.lines.lamp_ready |= view.state == State::kFault; }),
      Look("may move while armed",
           [](MachineView& view, const MachineView&) { view.may_move |= view.state == State::kArmed; }),
      Look("may move while it stops",
           [](MachineView& view, const MachineView&) { view.may_move |= view.state == State::kStopping; }),
      Look("a quick stop is forgotten at the next event",
           [](MachineView& view, const MachineView& before) {
             if (before.quick_stop) view.quick_stop = false;
           }),
  };
}

TEST(ScanMachineDefects, EveryDefectOfOrdersTimesMemoryAndOutputsIsCaught) {
  std::size_t planted = 0;
  std::size_t caught = 0;
  for (const auto& defects : {DefectsOfOrders(), DefectsOfTime(), DefectsOfMemory(), DefectsOfOutputs()}) {
    for (const Defect& defect : defects) {
      const char* rule = Caught(defect);
      ++planted;
      caught += rule != nullptr ? 1 : 0;
      EXPECT_NE(rule, nullptr) << defect.name;
      if (rule != nullptr) std::printf("  %-60s %s\n", defect.name.c_str(), rule);
    }
  }
  std::printf("%zu of %zu defects caught\n", caught, planted);
}

TEST(ScanMachineDefects, TheMachineWithoutADefectIsNotCaught) { EXPECT_EQ(Caught(Defect{}), nullptr); }

}  // namespace
}  // namespace annulus
