// Rows E: the safety inputs and outputs. Rows E1 and E4: estop_phases_test.cpp.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr milliseconds kTick{10};

bool RunTo(FaultRig& rig, ScanState state) {
  return rig.Operate([&] { return rig.fault_time() && rig.Now() > *rig.fault_time() && rig.state() == state; },
                     seconds(60));
}

bool ShowsNotice(FaultRig& rig, InterlockFault fault) {
  const std::vector<InterlockNotice> chain = rig.status().chain;
  return std::any_of(chain.begin(), chain.end(),
                     [&](const InterlockNotice& one) { return one.fault == fault && !one.text.empty(); });
}

/// A plan that opens the chain in mid-scan, for a moment: SAFE within a tick, and SAFE it stays.
std::string RunMoment(const std::string& row, const std::vector<CauseCode>& causes) {
  FaultRig rig(FaultRig::With(row));
  const auto scans = [&] { return rig.watch().When(ScanState::kScanning, nanoseconds(0)).has_value(); };
  if (!rig.Operate([&] { return scans() && rig.state() == ScanState::kSafe; }, seconds(60))) {
    return "not SAFE: " + rig.Told();
  }
  std::string wrong;
  nanoseconds began{0};
  for (const sim::FaultEvent& event : rig.injector().log()) {
    if (event.begins) began = event.time;
  }
  if (rig.Now() - began > milliseconds(100)) wrong += "SAFE only after " + InMs(rig.Now() - began) + "\n";
  ReportTimeToSafe(TimeToSafe(rig, began));
  rig.Pass(seconds(3));
  if (rig.state() != ScanState::kSafe) wrong += "it is not latched\n";
  return wrong + JudgeRun(rig, {causes});
}

TEST(FaultMatrix, E2_AChatteringEmergencyStopIsLatchedAtItsFirstOpening) {
  EXPECT_EQ(RunMoment("E2", {CauseCode::kChainOpen}), "");
  // More edges than the kernel keeps.
  EXPECT_EQ(RunMoment("E2_overflow", {CauseCode::kChainOpen}), "");
}

TEST(FaultMatrix, E3_ChannelsThatDisagreeAreLatchedUntilServiceHasLooked) {
  FaultRig rig(FaultRig::With("E3"));
  ASSERT_TRUE(RunTo(rig, ScanState::kSafe)) << rig.Told();
  EXPECT_LE(rig.Now() - *rig.fault_time(), kTick);
  rig.Pass(milliseconds(1500));
  EXPECT_TRUE(ShowsNotice(rig, InterlockFault::kChannelsDisagree)) << rig.Told();
  // An operator's reset is not taken.
  rig.PressReset();
  rig.Pass(milliseconds(600));
  EXPECT_EQ(rig.state(), ScanState::kSafe);
  EXPECT_FALSE(rig.Acknowledge(CauseRole::kOperator));
  rig.PressReset();
  rig.Pass(milliseconds(600));
  EXPECT_EQ(rig.state(), ScanState::kSafe) << rig.Told();
  ReportTimeToSafe(TimeToSafe(rig, *rig.fault_time()));
  // Service mends the channel and presses the button once, as the safety relay wants it.
  rig.chain().PressEstopAt(rig.Now());
  rig.chain().ReleaseEstopAt(rig.Now() + milliseconds(200));
  rig.Pass(milliseconds(300));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kChainOpen, CauseCode::kChannelsDiffer}}), "");
}

TEST(FaultMatrix, E5_ABrokenWireOfAnyInputIsADemandToStop) {
  for (const InterlockInput input :
       {InterlockInput::kEstopA, InterlockInput::kEstopB, InterlockInput::kDoor, InterlockInput::kUpperLimit,
        InterlockInput::kLowerLimit, InterlockInput::kWatchdogFeedback}) {
    FaultRigOptions options = FaultRig::With("E5");
    options.plan.faults.front().args.Set(sim::FaultArg::kInput, static_cast<double>(input));
    FaultRig rig(std::move(options));
    ASSERT_TRUE(RunTo(rig, ScanState::kSafe)) << InterlockName(input) << rig.Told();
    EXPECT_LE(rig.Now() - *rig.fault_time(), kTick) << InterlockName(input);
    rig.Pass(seconds(2));
    ReportTimeToSafe(TimeToSafe(rig, *rig.fault_time()));
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kChainOpen, CauseCode::kInterlock}}), "") << InterlockName(input);
  }
}

TEST(FaultMatrix, E5_ABrokenWireOfAFeedbackIsADemandAtRest) {
  // Both read "not at rest" when their wire breaks, as while the axis has power.
  for (const InterlockInput input : {InterlockInput::kEnableFeedback, InterlockInput::kBrakeFeedback}) {
    FaultRigOptions options = FaultRig::With("E5");
    sim::Fault& fault = options.plan.faults.front();
    fault.args.Set(sim::FaultArg::kInput, static_cast<double>(input));
    fault.at = {};
    fault.at.delay = seconds(5);
    FaultRig rig(std::move(options));
    ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed; }));
    ASSERT_TRUE(rig.RunUntil(ScanState::kSafe, seconds(5))) << rig.Told();
    rig.Pass(seconds(2));
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kWeldedContact, CauseCode::kBrakeSlip}}), "") << InterlockName(input);
  }
}

TEST(FaultMatrix, E6_AResetThatIsPressedAllTheTimeIsNoReset) {
  FaultRig rig(FaultRig::With("E6"));
  rig.Pass(seconds(7));
  EXPECT_EQ(rig.state(), ScanState::kSafe);
  EXPECT_TRUE(ShowsNotice(rig, InterlockFault::kResetStuck)) << rig.Told();
  rig.Pass(seconds(3));
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

TEST(FaultMatrix, E7_AResetWhileTheCauseIsThereIsRefusedAndNamesIt) {
  for (const InterlockInput input : {InterlockInput::kEstopA, InterlockInput::kDoor, InterlockInput::kUpperLimit}) {
    FaultRig rig;
    ASSERT_TRUE(rig.BringTo(ScanState::kIdle));
    rig.chain().Set(input, false);
    if (input == InterlockInput::kEstopA) rig.chain().Set(InterlockInput::kEstopB, false);
    rig.Pass(milliseconds(700));
    rig.PressReset();
    rig.Pass(milliseconds(700));
    EXPECT_EQ(rig.state(), ScanState::kSafe);
    EXPECT_THAT(rig.status().held_by, HasSubstr(InterlockName(input)));
    rig.chain().Set(input, true);
    if (input == InterlockInput::kEstopA) rig.chain().Set(InterlockInput::kEstopB, true);
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kChainOpen}}), "");
  }
}

TEST(FaultMatrix, E8_AfterAResetNothingMovesForAMinute) {
  FaultRig rig;
  ASSERT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") >= 10; }));
  rig.chain().PressEstopAt(rig.Now());
  rig.Pass(seconds(1));
  rig.chain().ReleaseEstopAt(rig.Now());
  rig.Pass(milliseconds(100));
  const std::size_t motions = rig.motions();
  const std::size_t writes = rig.drive().write_log().size();
  rig.PressReset();
  ASSERT_TRUE(rig.RunUntil(ScanState::kIdle, seconds(2))) << rig.Told();
  EXPECT_FALSE(rig.status().homed);
  const double z = rig.drive().TrueZ(rig.Now());
  rig.Pass(seconds(60));
  EXPECT_EQ(rig.state(), ScanState::kIdle);
  EXPECT_EQ(rig.motions(), motions);
  EXPECT_EQ(rig.drive().write_log().size(), writes);
  EXPECT_NEAR(rig.drive().TrueZ(rig.Now()), z, 1e-6);
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kChainOpen}}), "");
}

TEST(FaultMatrix, E9_ALampThatIsLostIsShown) {
  FaultRig rig(FaultRig::With("E9"));
  ASSERT_TRUE(rig.Operate([&] { return ShowsNotice(rig, InterlockFault::kLampLost); }, seconds(30))) << rig.Told();
  ASSERT_TRUE(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; })) << rig.Told();
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

TEST(FaultMatrix, E10_LinesThatAreMissingBusyOrRenamedKeepTheProgramFromRunning) {
  for (const char* row : {"E10_busy", "E10_renamed"}) {
    FaultRigOptions options = FaultRig::With(row);
    options.opens = false;
    FaultRig rig(std::move(options));
    EXPECT_FALSE(rig.opened());
    EXPECT_THAT(rig.opened().message(), HasSubstr("door")) << row;
  }
}

TEST(FaultMatrix, E10_AChipThatIsGoneInMidScanIsSafeForGood) {
  FaultRig rig(FaultRig::With("E10"));
  ASSERT_TRUE(RunTo(rig, ScanState::kSafe)) << rig.Told();
  EXPECT_LE(rig.Now() - *rig.fault_time(), kTick);
  ReportTimeToSafe(TimeToSafe(rig, *rig.fault_time()));
  rig.PressReset();
  rig.Pass(seconds(3));
  EXPECT_EQ(rig.state(), ScanState::kSafe);
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kInterlock}, Expected::Next::kNone}), "");
}

TEST(FaultMatrix, E10_LinesThatFailForAMomentAreSafe) {
  EXPECT_EQ(RunMoment("E10_fails", {CauseCode::kInterlock}), "");
}

TEST(FaultMatrix, E11_AWeldedEnableContactIsFoundAndRefused) {
  FaultRig rig(FaultRig::With("E11"));
  ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed; }));
  ASSERT_TRUE(rig.RunUntil(ScanState::kSafe, seconds(10))) << rig.Told();
  EXPECT_TRUE(ShowsNotice(rig, InterlockFault::kWeldedContact)) << rig.Told();
  EXPECT_FALSE(rig.Home());
  EXPECT_FALSE(rig.Arm());
  EXPECT_FALSE(rig.Acknowledge(CauseRole::kOperator));
  rig.PressReset();
  rig.Pass(seconds(3));
  EXPECT_EQ(rig.state(), ScanState::kSafe);
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kWeldedContact}}), "");
}

TEST(FaultMatrix, E12_AnEnableRelayThatDoesNotAnswerIsNamedWithin200Ms) {
  FaultRig rig(FaultRig::With("E12"));
  std::optional<nanoseconds> ordered;
  rig.on_tick = [&] {
    if (!ordered && rig.chain().Pin(InterlockOutput::kEnable)) ordered = rig.Now();
  };
  ASSERT_TRUE(rig.Operate([&] { return ordered && rig.state() == ScanState::kSafe; }, seconds(6))) << rig.Told();
  rig.on_tick = {};
  EXPECT_LE(rig.Now() - *ordered, milliseconds(200));
  ReportNote("named after " + InMs(rig.Now() - *ordered));
  EXPECT_TRUE(ShowsNotice(rig, InterlockFault::kNoEnableFeedback)) << rig.Told();
  rig.Pass(seconds(8));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kInterlock}}), "");
}

TEST(FaultMatrix, E13_WithoutAWatchdogRelayThatDropsNothingMoves) {
  for (const char* row : {"E13", "E13_welded"}) {
    FaultRig rig(FaultRig::With(row));
    EXPECT_FALSE(rig.begun()) << row;
    rig.Pass(milliseconds(100));
    rig.PressReset();
    rig.Pass(seconds(1));
    EXPECT_FALSE(rig.Home()) << row << rig.Told();
    EXPECT_FALSE(rig.Jog(Scanner::JogDirection::kUp));
    EXPECT_EQ(rig.motions(), 0U);
    EXPECT_EQ(rig.watch().violations(), std::vector<std::string>{}) << rig.Told();
  }
}

TEST(FaultMatrix, E13_TheWatchdogRelayIsMeasuredAtEveryStart) {
  FaultRig rig;
  EXPECT_TRUE(rig.begun()) << rig.begun().error().Text();
  // It pulled in and dropped once before the first tick.
  const auto pulled = WhenSignal(rig, sim::ChainSignal::kWatchdogRelay, true, nanoseconds(0));
  ASSERT_TRUE(pulled);
  const auto dropped = WhenSignal(rig, sim::ChainSignal::kWatchdogRelay, false, *pulled + nanoseconds(1));
  ASSERT_TRUE(dropped);
  EXPECT_LE(*dropped, rig.Now());
  rig.Kill();
  rig.Pass(milliseconds(300));
  ASSERT_TRUE(rig.Restart());
  EXPECT_TRUE(rig.begun());
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

}  // namespace
}  // namespace annulus::faults
