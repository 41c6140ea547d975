// Row E1: the E-stop at every 10 ms of a scan, and in every state. Row E4: the door.

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr milliseconds kTick{10};

/// How long a cycle from power-up to the end of the scan takes.
nanoseconds CycleTime() {
  static const nanoseconds time = [] {
    FaultRig rig;
    EXPECT_TRUE(rig.Operate([&] { return rig.status().scan.has_value() && rig.state() == ScanState::kIdle; }))
        << rig.Told();
    return rig.Now();
  }();
  return time;
}

/// Stop order on the quick-stop line at most a tick after the edge; enable with it. Empty: it was so.
std::string JudgeStopOrder(FaultRig& rig, nanoseconds pressed) {
  std::string wrong;
  const auto off = WhenSignal(rig, sim::ChainSignal::kQuickStopInput, false, pressed);
  if (!off || *off - pressed > kTick) wrong += "no stop order within a tick\n";
  if (rig.chain().Pin(InterlockOutput::kQuickStop)) wrong += "the quick-stop line is on\n";
  if (rig.chain().Pin(InterlockOutput::kEnable)) wrong += "enable is on\n";
  if (rig.chain().Pin(InterlockOutput::kEmitters)) wrong += "the emitters are on\n";
  return wrong;
}

/// The pins of the program, sampled at every tick: when it ordered the stop.
std::string JudgePins(FaultRig& rig, nanoseconds pressed) {
  std::optional<nanoseconds> ordered;
  rig.on_tick = [&] {
    if (!ordered && rig.Now() >= pressed && !rig.chain().Pin(InterlockOutput::kQuickStop)) ordered = rig.Now();
  };
  const bool came = rig.Operate([&] { return rig.Now() >= pressed + milliseconds(30); }, seconds(60));
  rig.on_tick = {};
  if (!came) return "the time of the stop did not come\n";
  // A tick sees the edge, and orders; the next one's look is what is told here.
  if (!ordered || *ordered > pressed + 2 * kTick) return "the program did not order the stop within a tick\n";
  return "";
}

/// The chain opens at a time of a scan's cycle, and closes again. Empty: all was as it must be.
struct Outcome {
  std::string wrong;
  nanoseconds to_safe{0};
};
Outcome PressAt(nanoseconds time, bool judges_all) {
  FaultRig rig;
  const nanoseconds pressed = std::max(rig.Now(), time);
  rig.chain().PressEstopAt(pressed);
  std::string wrong = JudgePins(rig, pressed);
  const auto at = rig.watch().StateBefore(pressed);
  wrong += JudgeStopOrder(rig, pressed);
  static_cast<void>(rig.RunUntil([&] { return rig.Now() >= pressed + milliseconds(600); }));
  if (rig.state() != ScanState::kSafe) wrong += "the state is not SAFE\n";
  const nanoseconds to_safe = TimeToSafe(rig, pressed);
  wrong += JudgeRest(rig);
  rig.chain().ReleaseEstopAt(rig.Now());
  if (judges_all) {
    // In SAFE nothing stops: the status says what holds the outputs.
    wrong += JudgeRun(rig, at == ScanState::kSafe ? Expected{} : Expected{{CauseCode::kChainOpen}});
  } else {
    for (const std::string& one : rig.watch().violations()) wrong += one + "\n";
  }
  return {wrong.empty() ? wrong : wrong + rig.Told(), to_safe};
}

TEST(FaultMatrix, E1_TheEmergencyStopStopsWithinATickInEveryPhaseOfAScan) {
  const bool all = std::getenv("ANNULUS_LONG") != nullptr;
  // Two phases for each tick of the cycle, so that there are more than 1,500.
  const auto phases = CycleTime() / milliseconds(5);
  EXPECT_GE(phases, 1500);
  int missed = 0;
  nanoseconds longest{0};
  for (std::int64_t phase = 0; phase < phases && missed < 5; ++phase) {
    // Anywhere between two ticks: the phase of the edge within the tick wanders.
    const nanoseconds time = phase * milliseconds(5) + std::chrono::microseconds(137 * phase % 5'000);
    const Outcome outcome = PressAt(time, all || phase % 16 == 0);
    longest = std::max(longest, outcome.to_safe);
    if (outcome.wrong.empty()) continue;
    ++missed;
    ADD_FAILURE() << "phase " << phase << ": " << outcome.wrong;
  }
  EXPECT_LE(longest, milliseconds(500));
  ReportTimeToSafe(longest);
  ReportNote(std::to_string(phases) + " phases, " + std::to_string(missed) + " missed");
}

/// A demand of the chain `after` the booth came into a state.
std::string DemandIn(ScanState state, InterlockInput input, nanoseconds after) {
  FaultRig rig;
  if (!rig.BringTo(state)) return std::string("not brought to ") + ScanStateText(state) + ": " + rig.Told();
  const nanoseconds opened = rig.Now() + after;
  rig.chain().SetAt(opened, input, false);
  if (input == InterlockInput::kEstopA) rig.chain().SetAt(opened, InterlockInput::kEstopB, false);
  std::string wrong;
  static_cast<void>(rig.RunUntil(
      [&] {
        if (state == ScanState::kJog && rig.state() == state) {
          static_cast<void>(rig.Jog(Scanner::JogDirection::kDown));
        }
        return rig.Now() >= opened && !rig.chain().Pin(InterlockOutput::kQuickStop);
      },
      seconds(1)));
  if (rig.Now() > opened + 2 * kTick) wrong += "the order came after " + InMs(rig.Now() - opened) + "\n";
  rig.Pass(milliseconds(600));
  if (rig.state() != ScanState::kSafe) wrong += "the state is not SAFE\n";
  wrong += JudgeStopOrder(rig, opened);
  if (TimeToSafe(rig, opened) > milliseconds(500)) wrong += "too late at rest\n";
  rig.chain().SetAt(rig.Now(), input, true);
  if (input == InterlockInput::kEstopA) rig.chain().SetAt(rig.Now(), InterlockInput::kEstopB, true);
  Expected expected{{CauseCode::kChainOpen}};
  if (state == ScanState::kFault) expected.causes = {CauseCode::kAxisFault};  // the first cause stays the first
  if (state == ScanState::kSafe) expected.causes = {};
  return wrong + JudgeRun(rig, expected);
}

constexpr ScanState kAllStates[] = {ScanState::kSafe,     ScanState::kIdle,     ScanState::kHoming, ScanState::kArmed,
                                    ScanState::kScanning, ScanState::kStopping, ScanState::kFault,  ScanState::kJog};

TEST(FaultMatrix, E1_TheEmergencyStopActsInEveryState) {
  for (const ScanState state : kAllStates) {
    for (const milliseconds after : {milliseconds(1), milliseconds(4), milliseconds(33), milliseconds(300)}) {
      if (state == ScanState::kStopping && after > milliseconds(40)) continue;  // it is over by then
      EXPECT_EQ(DemandIn(state, InterlockInput::kEstopA, after), "") << ScanStateText(state) << " + " << InMs(after);
    }
  }
}

TEST(FaultMatrix, E4_TheDoorAndTheLimitsActAsTheEmergencyStopInEveryState) {
  for (const InterlockInput input : {InterlockInput::kDoor, InterlockInput::kUpperLimit, InterlockInput::kLowerLimit}) {
    for (const ScanState state : kAllStates) {
      EXPECT_EQ(DemandIn(state, input, milliseconds(7)), "") << InterlockName(input) << " in " << ScanStateText(state);
    }
  }
}

}  // namespace
}  // namespace annulus::faults
