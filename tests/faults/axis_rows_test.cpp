// Rows A: the axis.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr milliseconds kTick{10};

bool Stopped(FaultRig& rig) { return rig.state() == ScanState::kFault || rig.state() == ScanState::kSafe; }

/// The operator takes a scan until the plan's fault has stopped it. False: it did not.
bool RunIntoTheFault(FaultRig& rig) {
  const auto moved = [&] { return rig.watch().When(ScanState::kHoming, nanoseconds(0)).has_value(); };
  return rig.Operate([&] { return rig.fault_time() && rig.Now() > *rig.fault_time() && moved() && Stopped(rig); },
                     seconds(150));
}

/// When the program ended the motion: the first state that does not move after the fault.
nanoseconds StoppedAt(FaultRig& rig) {
  const auto began = rig.watch().When(ScanState::kHoming, nanoseconds(0));
  nanoseconds first = nanoseconds::max();
  for (const ScanState state : {ScanState::kStopping, ScanState::kFault, ScanState::kSafe}) {
    const auto when = rig.watch().When(state, std::max(*rig.fault_time(), began.value_or(nanoseconds(0))));
    if (when) first = std::min(first, *when);
  }
  return first;
}

/// What every row has: stopped, the cause, at rest in time, and the next scan.
std::string RunRow(FaultRig& rig, const std::vector<CauseCode>& causes) {
  if (!RunIntoTheFault(rig)) return "nothing stopped: " + rig.Told();
  const nanoseconds safe = TimeToSafe(rig, StoppedAt(rig));
  ReportTimeToSafe(safe);
  std::string wrong;
  if (safe > milliseconds(500)) wrong += "at rest only after " + InMs(safe) + "\n";
  return wrong + JudgeRun(rig, {causes});
}

/// The first time after `from`, in steps of 0.5 ms, at which the truth fulfils `is`.
template <class Is>
std::optional<nanoseconds> FirstTime(FaultRig& rig, nanoseconds from, Is is) {
  for (nanoseconds time = from; time < rig.Now(); time += std::chrono::microseconds(500)) {
    if (is(time)) return time;
  }
  return std::nullopt;
}

TEST(FaultMatrix, A1_AnAxisThatLagsBehindIsStoppedTwoTicksAfterTheLimit) {
  FaultRig rig(FaultRig::With("A1"));
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  const nanoseconds fault = *rig.fault_time();
  const double z = rig.drive().TrueZ(fault);
  const double speed = rig.drive().TrueSpeed(fault);
  // Of the sweep's speed, downwards; the motor follows its set-point by 4 ms from the start.
  const AxisLimits& limits = rig.drive().options().limits;
  const double limit = 2.0 + 4.0 * std::abs(speed) / limits.max_speed.value();
  const auto beyond = FirstTime(rig, fault, [&](nanoseconds time) {
    const double ideal = z + speed * (static_cast<double>((time - fault).count()) * 1e-9 + 0.004);
    return std::abs(rig.drive().TrueZ(time) - ideal) > limit;
  });
  ASSERT_TRUE(beyond);
  EXPECT_LE(StoppedAt(rig) - *beyond, 2 * kTick);
  ReportNote("stopped " + InMs(StoppedAt(rig) - *beyond) + " after the limit");
  ReportTimeToSafe(TimeToSafe(rig, *beyond));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kFollowingError, CauseCode::kAxisFault}}), "");
}

TEST(FaultMatrix, A2_AnAxisThatMeetsSomethingStopsAndDoesNotTurnBackByItself) {
  for (const char* row : {"A2", "A2_overload"}) {
    FaultRig rig(FaultRig::With(row));
    ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
    const nanoseconds stopped = StoppedAt(rig);
    rig.Pass(milliseconds(600));
    const double z = rig.drive().TrueZ(rig.Now());
    const std::size_t motions = rig.motions();
    ReportTimeToSafe(TimeToSafe(rig, stopped));
    EXPECT_LE(TimeToSafe(rig, stopped), milliseconds(500));
    rig.Pass(seconds(10));
    EXPECT_EQ(rig.motions(), motions);
    EXPECT_NEAR(rig.drive().TrueZ(rig.Now()), z, 0.01);
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kFollowingError, CauseCode::kAxisFault}}), "") << row;
  }
}

TEST(FaultMatrix, A3_ABrakeThatSlipsIsFoundWithinAMillimetreAndNeedsService) {
  for (const bool homed : {true, false}) {
    FaultRig rig(FaultRig::With("A3"));
    ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed == homed; }));
    const double z = rig.drive().TrueZ(rig.Now());
    ASSERT_TRUE(rig.RunUntil(ScanState::kFault, seconds(10))) << rig.Told();
    EXPECT_LE(std::abs(rig.drive().TrueZ(rig.Now()) - z), 1.0);
    ReportNote("found after " + std::to_string(std::abs(rig.drive().TrueZ(rig.Now()) - z)).substr(0, 4) + " mm");
    EXPECT_FALSE(rig.status().homed);
    EXPECT_FALSE(rig.Acknowledge(CauseRole::kOperator)) << "only service may";
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kBrakeSlip}}), "") << homed;
  }
}

TEST(FaultMatrix, A4_AnEncoderThatJumpsStopsAndLosesHome) {
  for (const char* row : {"A4", "A4_down"}) {
    FaultRig rig(FaultRig::With(row));
    ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
    EXPECT_FALSE(rig.status().homed);
    EXPECT_LE(StoppedAt(rig) - *rig.fault_time(), 2 * kTick);
    EXPECT_EQ(RunRow(rig, {CauseCode::kEncoderJump}), "") << row;
  }
}

TEST(FaultMatrix, A5_AHomeSwitchThatNeverClosesEndsWithinTheTravel) {
  FaultRig rig(FaultRig::With("A5"));
  EXPECT_EQ(RunRow(rig, {CauseCode::kHoming, CauseCode::kAxisFault}), "");
  EXPECT_GE(rig.motions(), 1U);
}

TEST(FaultMatrix, A6_AHomeSwitchThatIsStuckIsNotTakenForHome) {
  FaultRig rig(FaultRig::With("A6"));
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  EXPECT_FALSE(rig.status().homed);
  EXPECT_EQ(RunRow(rig, {CauseCode::kHoming, CauseCode::kAxisFault, CauseCode::kWrongDirection}), "");
}

TEST(FaultMatrix, A6_AHomingThatBeginsOnTheSwitchIsNoFault) {
  for (const double z : {2239.9, 2241.0, 2249.0}) {
    FaultRigOptions options = FaultRig::Defaults();
    options.booth.axis.start_z_mm = z;
    FaultRig rig(std::move(options));
    ASSERT_TRUE(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; })) << z << rig.Told();
    EXPECT_EQ(JudgeRun(rig, {}), "") << z;
  }
}

TEST(FaultMatrix, A7_AtALimitTheDriveStopsAndOnlyTheWayBackIsFree) {
  FaultRig rig(FaultRig::With("A7"));
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  ReportTimeToSafe(TimeToSafe(rig, *rig.fault_time()));
  EXPECT_LE(TimeToSafe(rig, *rig.fault_time()), milliseconds(500));
  rig.Pass(milliseconds(700));
  ASSERT_TRUE(rig.Acknowledge(CauseRole::kOperator));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.state() == ScanState::kIdle && rig.status().job.empty(); }, seconds(3)));
  // Upwards it may go, to its home; then down by hand it must not.
  ASSERT_TRUE(rig.Home());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.status().homed; }, seconds(20))) << rig.Told();
  ASSERT_TRUE(rig.RunUntil([&] { return rig.status().job.empty(); }, seconds(3)));
  const double z = rig.drive().TrueZ(rig.Now());
  ASSERT_TRUE(rig.Jog(Scanner::JogDirection::kDown));
  static_cast<void>(rig.RunUntil(
      [&] {
        static_cast<void>(rig.Jog(Scanner::JogDirection::kDown));
        return Stopped(rig);
      },
      seconds(2)));
  EXPECT_EQ(rig.state(), ScanState::kFault) << rig.Told();
  EXPECT_NEAR(rig.drive().TrueZ(rig.Now()), z, 0.1);
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(40)));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kAxisFault, CauseCode::kLimit}}), "");
}

TEST(FaultMatrix, A8_WithBothLimitsOpenNothingMoves) {
  FaultRig rig(FaultRig::With("A8"));
  const double z = rig.drive().TrueZ(rig.Now());
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  EXPECT_NEAR(rig.drive().TrueZ(rig.Now()), z, 0.01);
  EXPECT_EQ(RunRow(rig, {CauseCode::kAxisFault, CauseCode::kLimit}), "");
}

TEST(FaultMatrix, A9_EveryFaultOfTheDriveStopsWithItsText) {
  for (const unsigned code :
       {0x2310U, 0x3210U, 0x3220U, 0x4310U, 0x5441U, 0x5442U, 0x7121U, 0x7305U, 0x8611U, 0xFF01U}) {
    FaultRigOptions options = FaultRig::With("A9");
    options.plan.faults.front().args.Set(sim::FaultArg::kCode, code);
    FaultRig rig(std::move(options));
    ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
    ASSERT_FALSE(rig.status().causes.empty());
    char hex[8];
    std::snprintf(hex, sizeof(hex), "%04Xh", code);
    EXPECT_THAT(rig.status().causes.front().text, HasSubstr(hex));
    EXPECT_EQ(RunRow(rig, {CauseCode::kAxisFault}), "") << hex;
  }
}

TEST(FaultMatrix, A10_AnAxisThatMovesWithoutAnOrderIsFoundWithin50Ms) {
  for (const char* row : {"A10", "A10_up"}) {
    for (const bool homed : {true, false}) {
      FaultRig rig(FaultRig::With(row));
      ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed == homed; }));
      ASSERT_TRUE(rig.RunUntil([&] { return Stopped(rig); }, seconds(10))) << rig.Told();
      const nanoseconds took = rig.Now() - *rig.fault_time();
      EXPECT_LE(took, milliseconds(50)) << row;
      ReportNote(InMs(took));
      EXPECT_FALSE(rig.chain().Pin(InterlockOutput::kEnable));
      EXPECT_FALSE(rig.status().homed);
      EXPECT_EQ(JudgeRun(rig, {{CauseCode::kUnorderedMove}}), "") << row << (homed ? ", homed" : "");
    }
  }
}

TEST(FaultMatrix, A11_AnAxisThatGoesTheWrongWayIsStoppedWithin5Mm) {
  FaultRig rig(FaultRig::With("A11"));
  const double z = rig.drive().TrueZ(rig.Now());
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  rig.Pass(milliseconds(500));
  const double way = std::abs(rig.drive().TrueZ(rig.Now()) - z);
  EXPECT_LE(way, 5.0);
  ReportNote("stopped after " + std::to_string(way).substr(0, 4) + " mm");
  EXPECT_EQ(RunRow(rig, {CauseCode::kWrongDirection}), "");
}

TEST(FaultMatrix, A12_AnAxisThatIsTooFastIsStoppedWithinTwoTicks) {
  FaultRig rig(FaultRig::With("A12"));
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  const double ordered = std::abs(rig.drive().TrueSpeed(*rig.fault_time()));
  const auto beyond = FirstTime(rig, *rig.fault_time(), [&](nanoseconds time) {
    return std::abs(rig.drive().TrueSpeed(time)) > 1.1 * ordered + 3.0;
  });
  ASSERT_TRUE(beyond);
  EXPECT_LE(StoppedAt(rig) - *beyond, 2 * kTick);
  ReportNote("stopped " + InMs(StoppedAt(rig) - *beyond) + " after the limit");
  EXPECT_EQ(RunRow(rig, {CauseCode::kOverspeed}), "");
}

TEST(FaultMatrix, A13_AStopThatIsNotReachedIsTakenOutOfTheDrivesHands) {
  for (const char* row : {"A13", "A13_quick_stop"}) {
    FaultRig rig(FaultRig::With(row));
    ASSERT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") >= 25; })) << rig.Told();
    const nanoseconds ordered = rig.Now();
    ASSERT_TRUE(rig.Cancel());
    rig.Pass(milliseconds(1500));
    const auto line = WhenSignal(rig, sim::ChainSignal::kQuickStopInput, false, ordered);
    ASSERT_TRUE(line) << rig.Told();
    EXPECT_LE(*line - ordered, milliseconds(310)) << row;
    const auto torque = WhenSignal(rig, sim::ChainSignal::kStoA, false, ordered);
    ASSERT_TRUE(torque) << rig.Told();
    // The program drops enable 500 ms after the stop began; the relay's contacts to the torque follow 215 ms later.
    EXPECT_LE(*torque - ordered, milliseconds(500 + 10 + 215)) << row;
    if (std::string(row) == "A13") {
      EXPECT_LE(TimeToSafe(rig, ordered), milliseconds(500));
      ReportTimeToSafe(TimeToSafe(rig, ordered));
    }
    ReportNote(std::string(row) + ": quick-stop line after " + InMs(*line - ordered) + ", torque off after " +
               InMs(*torque - ordered));
    static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(5)));
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kStopOverdue}}), "") << row;
  }
}

TEST(FaultMatrix, A14_ADriveWithoutMainsIsHeldByItsBrakeAndHasToHomeAgain) {
  FaultRig rig(FaultRig::With("A14"));
  ASSERT_TRUE(RunIntoTheFault(rig)) << rig.Told();
  EXPECT_FALSE(rig.status().homed);
  const std::size_t motions = rig.motions();
  rig.Pass(milliseconds(500));
  const double z = rig.drive().TrueZ(rig.Now());
  rig.Pass(seconds(10));
  EXPECT_EQ(rig.motions(), motions);
  EXPECT_NEAR(rig.drive().TrueZ(rig.Now()), z, 0.01);
  EXPECT_EQ(RunRow(rig, {CauseCode::kAxisLink}), "");
}

/// A parameter of the drive is changed after homing: what arming says.
std::string ArmWithChangedParameters(FaultRig& rig) {
  if (!rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed; })) return "not homed";
  rig.Pass(milliseconds(5100) - rig.Now());
  const Status ordered = rig.Arm();
  if (!ordered) return ordered.error().Text();
  if (!rig.RunUntil([&] { return rig.status().arm.has_value() && rig.status().job.empty(); }, seconds(5)))
    return "no answer";
  if (rig.state() != ScanState::kIdle) return "armed";
  const ArmReport report = rig.status().arm.value_or(ArmReport{});
  for (const ArmCheck& check : report.checks) {
    if (!check.result && check.name == "drive") return "";
  }
  return "refused for another reason: " + rig.Told();
}

std::string RunParameterRow(const std::string& row, sim::AxisMishap repair) {
  FaultRig rig(FaultRig::With(row));
  std::string wrong = ArmWithChangedParameters(rig);
  repair.kind = sim::AxisMishapKind::kParameter;
  repair.from = rig.Now();
  rig.drive().Suffer(repair);
  return wrong + JudgeRun(rig, {});
}

TEST(FaultMatrix, A15_ParametersThatWereChangedAreNotArmed) {
  EXPECT_EQ(RunParameterRow("A15", {.value = 4000.0, .code = sim::AxisParameterRegisters::kQuickStop}), "");
}

TEST(FaultMatrix, M10_AnotherMastersWriteToTheDriveIsNotArmed) {
  EXPECT_EQ(RunParameterRow("M10", {.value = 2250.0, .code = sim::AxisParameterRegisters::kZMax}), "");
}

TEST(FaultMatrix, M12_ADriveWhoseWatchdogIsOffOrSlowIsNotArmed) {
  for (const char* row : {"M12", "M12_off"}) {
    EXPECT_EQ(RunParameterRow(row, {.value = 200.0, .code = sim::AxisParameterRegisters::kHeartbeat}), "") << row;
  }
}

}  // namespace
}  // namespace annulus::faults
