// What the machine forgets, and what the time brings.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "tests/acquisition/scan_machine_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using test::Codes;
using test::Do;
using test::Event;
using test::In;
using test::kBegin;
using test::kLongest;
using testing::ElementsAre;
using Kind = ScanEventKind;
using State = ScanState;

TEST(ScanMachine, ALostLinkAJumpAndADriveFaultLoseHome) {
  for (const CauseCode code : {CauseCode::kAxisLink, CauseCode::kEncoderJump, CauseCode::kAxisFault}) {
    for (const State state : {State::kIdle, State::kArmed, State::kScanning, State::kStopping, State::kFault}) {
      ScanMachine machine = In(state);
      ASSERT_TRUE(machine.homed());
      ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, code)));
      EXPECT_FALSE(machine.homed());
    }
  }
  ScanMachine machine = In(State::kScanning);
  ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kStorage)));
  EXPECT_TRUE(machine.homed()) << "a full disk does not move the carriage";
}

TEST(ScanMachine, AHomingThatIsBrokenOffLeavesNoOldHome) {
  for (const Kind end : {Kind::kCancelled, Kind::kFaulted, Kind::kHomingFailed}) {
    ScanMachine machine = In(State::kIdle);
    ASSERT_TRUE(machine.homed());
    ASSERT_TRUE(Do(machine, Event(Kind::kHomeOrdered)));
    ASSERT_TRUE(Do(machine, Event(end, CauseCode::kSensorLost)));
    EXPECT_EQ(machine.state(), State::kStopping);
    ASSERT_TRUE(Do(machine, Event(Kind::kHomed))) << "what is reported late means nothing";
    EXPECT_FALSE(machine.homed());
    ASSERT_TRUE(Do(machine, Event(Kind::kStopped)));
    EXPECT_EQ(machine.state(), end == Kind::kCancelled ? State::kIdle : State::kFault);
    EXPECT_FALSE(machine.homed());
  }
}

TEST(ScanMachine, AJogKeepsHome) {
  ScanMachine machine = In(State::kJog);
  ASSERT_TRUE(Do(machine, Event(Kind::kJogReleased)));
  ASSERT_TRUE(Do(machine, Event(Kind::kStopped)));
  EXPECT_EQ(machine.state(), State::kIdle);
  EXPECT_TRUE(machine.homed());
}

/// When something first becomes due, to the nanosecond; from a state that was entered at kBegin.
nanoseconds DueAfter(const ScanMachine& machine, nanoseconds expected, Kind kind) {
  EXPECT_FALSE(machine.Due(kBegin + expected - nanoseconds(1)));
  const auto due = machine.Due(kBegin + expected);
  if (!due) return nanoseconds(-1);
  EXPECT_EQ(due->kind, kind);
  return due->time - kBegin;
}

TEST(ScanMachineTime, EveryStateThatWaitsForAMachineEnds) {
  EXPECT_EQ(DueAfter(In(State::kHoming), seconds(95), Kind::kHomingFailed), seconds(95));
  EXPECT_EQ(DueAfter(In(State::kArmed), seconds(60), Kind::kArmExpired), seconds(60));
  EXPECT_EQ(DueAfter(In(State::kScanning), kLongest, Kind::kFaulted), kLongest);
  EXPECT_EQ(DueAfter(In(State::kStopping), milliseconds(300), Kind::kStopLate), milliseconds(300));
  EXPECT_EQ(DueAfter(In(State::kJog), milliseconds(100), Kind::kJogReleased), milliseconds(100));
  for (const State state : {State::kSafe, State::kIdle, State::kFault})
    EXPECT_FALSE(In(state).Due(kBegin + std::chrono::hours(10000))) << ScanStateText(state);
}

TEST(ScanMachineTime, AStopThatIsLateDemandsTheQuickStopLineAndThenLosesEnable) {
  ScanMachine machine = In(State::kScanning);
  ASSERT_TRUE(Do(machine, Event(Kind::kCancelled)));
  EXPECT_TRUE(machine.Lines().quick_stop);
  ASSERT_TRUE(Do(machine, *machine.Due(kBegin + milliseconds(300))));
  EXPECT_EQ(machine.state(), State::kStopping);
  EXPECT_FALSE(machine.Lines().quick_stop);
  EXPECT_TRUE(machine.Lines().enable);
  EXPECT_FALSE(machine.Due(kBegin + milliseconds(499)));
  ASSERT_TRUE(Do(machine, *machine.Due(kBegin + milliseconds(500))));
  EXPECT_EQ(machine.state(), State::kSafe);
  EXPECT_FALSE(machine.Lines().enable);
  EXPECT_FALSE(machine.homed());
  EXPECT_THAT(Codes(machine), ElementsAre(CauseCode::kStopOverdue));
  ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
  EXPECT_EQ(machine.state(), State::kFault) << "somebody has to look at the brake";
}

TEST(ScanMachineTime, AHangingTickGoesStraightToTheOverdueStop) {
  ScanMachine machine = In(State::kStopping);
  EXPECT_EQ(machine.Due(kBegin + seconds(5))->kind, Kind::kStopOverdue);
}

TEST(ScanMachineTime, NothingWhileItStopsMovesTheDeadline) {
  for (const Kind kind : {Kind::kCancelled, Kind::kFaulted, Kind::kLastLevel, Kind::kStopLate, Kind::kHomingFailed}) {
    ScanMachine machine = In(State::kScanning);
    ASSERT_TRUE(Do(machine, Event(Kind::kCancelled)));
    ASSERT_TRUE(Do(machine, Event(kind, CauseCode::kAxisLink, kBegin + milliseconds(250))));
    EXPECT_EQ(machine.state(), State::kStopping);
    const auto before = machine.Due(kBegin + milliseconds(499));
    EXPECT_TRUE(!before || before->kind == Kind::kStopLate);
    ASSERT_TRUE(machine.Due(kBegin + milliseconds(500)));
    EXPECT_EQ(machine.Due(kBegin + milliseconds(500))->kind, Kind::kStopOverdue);
  }
}

TEST(ScanMachineTime, ACauseThatDistrustsTheDriveDemandsTheQuickStopLineAtOnce) {
  for (const State state : {State::kHoming, State::kScanning, State::kJog, State::kStopping}) {
    ScanMachine ramp = In(state);
    ASSERT_TRUE(Do(ramp, Event(Kind::kFaulted, CauseCode::kSensorLost)));
    EXPECT_TRUE(ramp.Lines().quick_stop);
    ScanMachine line = In(state);
    ASSERT_TRUE(Do(line, Event(Kind::kFaulted, CauseCode::kFollowingError)));
    EXPECT_FALSE(line.Lines().quick_stop);
    EXPECT_EQ(DueAfter(line, milliseconds(500), Kind::kStopOverdue), milliseconds(500));
    ASSERT_TRUE(Do(line, Event(Kind::kFaulted, CauseCode::kSensorLost)));
    EXPECT_FALSE(line.Lines().quick_stop) << "once demanded, until it rests";
  }
}

TEST(ScanMachineTime, AHomingThatFailsForTheDriveDemandsTheQuickStopLine) {
  ScanMachine machine = In(State::kHoming);
  ASSERT_TRUE(Do(machine, Event(Kind::kHomingFailed, CauseCode::kWrongDirection)));
  EXPECT_FALSE(machine.Lines().quick_stop);
  machine = In(State::kScanning);
  ASSERT_TRUE(Do(machine, Event(Kind::kCancelled, CauseCode::kWrongDirection)));
  EXPECT_TRUE(machine.Lines().quick_stop) << "a cancel has no cause";
}

TEST(ScanMachineTime, TheNextStopBeginsWithARampAgain) {
  ScanMachine machine = In(State::kJog);
  ASSERT_TRUE(Do(machine, Event(Kind::kJogReleased)));
  ASSERT_TRUE(Do(machine, Event(Kind::kStopLate)));
  EXPECT_TRUE(machine.quick_stop_demanded());
  ASSERT_TRUE(Do(machine, Event(Kind::kStopped)));
  EXPECT_FALSE(machine.quick_stop_demanded());
  ASSERT_TRUE(Do(machine, Event(Kind::kStopped))) << "told twice";
  EXPECT_EQ(machine.state(), State::kIdle);
  ASSERT_TRUE(Do(machine, Event(Kind::kJogOrdered)));
  ASSERT_TRUE(Do(machine, Event(Kind::kCancelled)));
  EXPECT_TRUE(machine.Lines().quick_stop);
}

TEST(ScanMachineTime, AJogLastsForAsLongAsItsBeat) {
  ScanMachine machine = In(State::kJog);
  const std::uint64_t version = machine.version();
  nanoseconds now = kBegin;
  for (int beat = 0; beat < 100; ++beat) {
    now += milliseconds(99);
    ASSERT_FALSE(machine.Due(now));
    if (beat % 2 == 0) {
      machine.JogBeat(now);
    } else {
      ASSERT_TRUE(Do(machine, Event(Kind::kJogOrdered, now)));
    }
  }
  EXPECT_EQ(machine.version(), version);
  const auto due = machine.Due(now + milliseconds(100));
  ASSERT_TRUE(due);
  ASSERT_TRUE(Do(machine, *due));
  EXPECT_EQ(machine.state(), State::kStopping);
  machine.JogBeat(now + milliseconds(101));
  EXPECT_FALSE(machine.may_move()) << "a late beat does not bring the motion back";
  EXPECT_FALSE(Do(machine, Event(Kind::kJogOrdered)));
}

TEST(ScanMachineTime, ABeatFromBeforeTheOrderDoesNotProlongAJog) {
  ScanMachine machine = In(State::kIdle);
  machine.JogBeat(kBegin + seconds(10));
  ASSERT_TRUE(Do(machine, Event(Kind::kJogOrdered)));
  EXPECT_TRUE(machine.Due(kBegin + milliseconds(100)));
}

}  // namespace
}  // namespace annulus
