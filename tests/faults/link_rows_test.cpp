// Rows M: the link to the axis drive. Rows M10 and M12: axis_rows_test.cpp. What concerns one transaction only is
// tested with the driver (tests/firmware_iface); here it is the whole program's answer.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr milliseconds kTick{10};
constexpr sim::ModbusNumbering kBothLinks[] = {sim::ModbusNumbering::kNone, sim::ModbusNumbering::kTransaction};

bool Stopped(FaultRig& rig) { return rig.state() == ScanState::kFault || rig.state() == ScanState::kSafe; }

/// Until a scan is over, in whatever way.
bool RunThrough(FaultRig& rig) {
  const auto moved = [&] { return rig.watch().When(ScanState::kHoming, nanoseconds(0)).has_value(); };
  return rig.Operate(
      [&] {
        const ScannerStatus seen = rig.status();
        return (moved() && Stopped(rig)) || (seen.scan && seen.state == ScanState::kIdle && seen.job.empty());
      },
      seconds(60));
}

/// A disturbance that a scan bears.
std::string Bears(const std::string& row, sim::ModbusNumbering link) {
  FaultRigOptions options = FaultRig::With(row);
  options.link = link;
  FaultRig rig(std::move(options));
  if (!RunThrough(rig)) return "no end: " + rig.Told();
  std::string wrong;
  if (!rig.status().scan || !rig.status().scan->complete) wrong += "the scan is not complete\n";
  return wrong + JudgeRun(rig, {});
}

/// One that it does not bear: stopped, link named, re-homed, next scan.
std::string StopsAt(const std::string& row, sim::ModbusNumbering link, const std::vector<CauseCode>& causes) {
  FaultRigOptions options = FaultRig::With(row);
  options.link = link;
  FaultRig rig(std::move(options));
  if (!rig.Operate([&] { return rig.fault_time() && rig.Now() > *rig.fault_time() && Stopped(rig); }, seconds(60))) {
    return "nothing stopped: " + rig.Told();
  }
  std::string wrong;
  if (rig.status().homed) wrong += "still homed\n";
  const std::size_t motions = rig.motions();
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(20)));
  rig.Pass(seconds(3));
  if (rig.motions() != motions) wrong += "something moved afterwards\n";
  const nanoseconds safe = TimeToSafe(rig, *rig.fault_time());
  ReportTimeToSafe(safe);
  if (safe > milliseconds(500)) wrong += "at rest only after " + InMs(safe) + "\n";
  return wrong + JudgeRun(rig, {causes});
}

TEST(FaultMatrix, M1_AMissingReplyIsReadAgainAndTheScanGoesOn) {
  for (const auto link : kBothLinks) EXPECT_EQ(Bears("M1", link), "");
}

TEST(FaultMatrix, M1_AMissingReplyToAnyRequestNeverMovesTwice) {
  const std::uint64_t step = std::getenv("ANNULUS_LONG") != nullptr ? 7 : 61;
  int tried = 0;
  int stopped = 0;
  FaultRig undisturbed;
  ASSERT_TRUE(undisturbed.Operate([&] { return undisturbed.state() == ScanState::kHoming; }));
  const auto homing = static_cast<std::uint64_t>(undisturbed.link().transactions());
  ASSERT_TRUE(RunThrough(undisturbed));
  // Beyond it the fault would meet the scan by which the judge shows that the next one passes.
  const auto last = static_cast<std::uint64_t>(undisturbed.link().transactions());
  for (const sim::FaultKind kind : {sim::FaultKind::kLinkLoseReply, sim::FaultKind::kLinkLoseRequest}) {
    // The orders that enable and home are looked at one by one.
    for (std::uint64_t call = 1; call < last;
         call += (call + step > homing && call < homing + 40 ? 1 : step), ++tried) {
      FaultRigOptions options = FaultRig::With("M1");
      sim::Fault& fault = options.plan.faults.front();
      fault.at = {};
      fault.at.kind = sim::FaultTrigger::Kind::kCall;
      fault.at.number = call;
      fault.kind = kind;
      options.opens = call > 40;  // the opening of the devices may fail, and says so
      FaultRig rig(std::move(options));
      if (!rig.opened()) continue;
      ASSERT_TRUE(RunThrough(rig)) << call << rig.Told();
      EXPECT_LE(rig.motions(), undisturbed.motions()) << call;
      if (!Stopped(rig)) {
        EXPECT_EQ(JudgeRun(rig, {}), "") << call;
        continue;
      }
      ++stopped;
      EXPECT_EQ(JudgeRun(rig, {{CauseCode::kAxisLink, CauseCode::kAxisFault}}), "") << call;
    }
  }
  ReportNote(std::to_string(tried) + " requests tried, " + std::to_string(stopped) + " stopped the scan");
}

TEST(FaultMatrix, M2_LateRepliesOnASerialLineAreNeverTakenForOthers) {
  EXPECT_EQ(Bears("M2", sim::ModbusNumbering::kNone), "");
}

TEST(FaultMatrix, M2_ALineFullOfLateRepliesGivesNoWrongPlace) {
  const int runs = std::getenv("ANNULUS_LONG") != nullptr ? 40 : 6;
  for (int run = 0; run < runs; ++run) {
    FaultRigOptions options = FaultRig::With("M2");
    options.link = sim::ModbusNumbering::kNone;
    options.plan.seed = 100 + static_cast<std::uint64_t>(run);
    options.plan.faults.resize(1);
    sim::Fault& fault = options.plan.faults.front();
    fault.args = {};
    fault.args.Set(sim::FaultArg::kShare, 0.05);
    fault.args.Set(sim::FaultArg::kDelayMs, 31.0 + 20.0 * (run % 6));
    fault.lasting = seconds(3);
    FaultRig rig(std::move(options));
    ASSERT_TRUE(RunThrough(rig)) << rig.Told();
    const bool stopped = Stopped(rig);
    static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(20)));
    EXPECT_EQ(JudgeRun(rig, stopped ? Expected{{CauseCode::kAxisLink}} : Expected{}), "") << run;
  }
}

TEST(FaultMatrix, M3_ALateReplyOfTcpIsOverWithin500Ms) {
  EXPECT_EQ(Bears("M3", sim::ModbusNumbering::kTransaction), "");
}

TEST(FaultMatrix, M4_DamagedRepliesAreRefusedAndOneOfThemStopsNothing) {
  for (const auto link : kBothLinks) {
    EXPECT_EQ(Bears("M4", link), "");
    EXPECT_EQ(StopsAt("M4_all", link, {CauseCode::kAxisLink}), "");
    // Two replies at once spoil two readings in a row, which is one too many.
    EXPECT_EQ(StopsAt("M4_merged", link, {CauseCode::kAxisLink}), "");
  }
}

TEST(FaultMatrix, M5_ABusyDriveIsAskedAgainAndOtherExceptionsAreNamed) {
  EXPECT_EQ(Bears("M5", sim::ModbusNumbering::kTransaction), "");
  for (const int code : {1, 2, 3, 4, 6}) {
    FaultRigOptions options = FaultRig::With("M5");
    options.plan.faults.front().args.Set(sim::FaultArg::kCode, code);
    options.plan.faults.front().args.Set(sim::FaultArg::kCount, 12);
    FaultRig rig(std::move(options));
    ASSERT_TRUE(rig.Operate([&] { return rig.fault_time() && Stopped(rig); }, seconds(60))) << code << rig.Told();
    EXPECT_THAT(rig.status().causes.front().text, testing::Not(testing::IsEmpty()));
    ReportTimeToSafe(TimeToSafe(rig, *rig.fault_time()));
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kAxisLink, CauseCode::kAxisFault}}), "") << code;
  }
}

TEST(FaultMatrix, M6_AGatewayThatIsAwayForTenSecondsCostsTheHome) {
  for (const auto link : kBothLinks) EXPECT_EQ(StopsAt("M6", link, {CauseCode::kAxisLink}), "");
}

TEST(FaultMatrix, M7_APeerThatWasFrozenMovesNothingWhenItGoesOn) {
  for (const auto link : kBothLinks) EXPECT_EQ(StopsAt("M7", link, {CauseCode::kAxisLink}), "");
}

TEST(FaultMatrix, M7_APeerThatFreezesAtAnyRequestMovesNothingWhenItGoesOn) {
  const std::uint64_t step = std::getenv("ANNULUS_LONG") != nullptr ? 11 : 97;
  int tried = 0;
  for (std::uint64_t call = 45; call < 1800; call += step, ++tried) {
    FaultRigOptions options = FaultRig::With("M7");
    sim::Fault& fault = options.plan.faults.front();
    fault.at = {};
    fault.at.kind = sim::FaultTrigger::Kind::kCall;
    fault.at.number = call;
    options.link = kBothLinks[tried % 2];
    FaultRig rig(std::move(options));
    if (!rig.Operate([&] { return rig.fault_time() && Stopped(rig) && rig.Now() > *rig.fault_time(); }, seconds(60))) {
      continue;  // at rest, or over: nothing was ordered
    }
    const std::size_t motions = rig.motions();
    static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(20)));
    rig.Pass(seconds(2));
    EXPECT_EQ(rig.motions(), motions) << call;
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kAxisLink}}), "") << call;
  }
  ReportNote(std::to_string(tried) + " requests tried");
}

TEST(FaultMatrix, M8_AnAdapterThatComesBackIsUsedAgain) {
  FaultRig rig(FaultRig::With("M8"));
  ASSERT_TRUE(rig.Operate([&] { return rig.fault_time() && Stopped(rig); }, seconds(60))) << rig.Told();
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(10)));
  const nanoseconds back = rig.Now();
  ASSERT_TRUE(rig.RunUntil(
      [&] {
        if (rig.state() == ScanState::kFault && rig.status().job.empty())
          static_cast<void>(rig.Acknowledge(CauseRole::kOperator));
        return rig.state() == ScanState::kIdle;
      },
      seconds(10)))
      << rig.Told();
  EXPECT_LE(rig.Now() - back, seconds(3));
  ReportNote("back after " + InMs(rig.Now() - back));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kAxisLink}}), "");
}

TEST(FaultMatrix, M9_SlowRepliesAreRepliesAsLongAsTheyAreInTime) {
  for (const auto link : kBothLinks) EXPECT_EQ(Bears("M9", link), "");
}

TEST(FaultMatrix, M11_TheDriveOfAKilledProgramStopsByItsHardware) {
  FaultRig rig(FaultRig::With("M11"));
  static_cast<void>(rig.Operate([&] { return rig.fault_time().has_value(); }, seconds(60)));
  ASSERT_TRUE(rig.fault_time());
  const nanoseconds killed = *rig.fault_time();
  const std::size_t motions = rig.motions();
  rig.Pass(seconds(1));
  const auto off = WhenSignal(rig, sim::ChainSignal::kQuickStopInput, false, killed);
  ASSERT_TRUE(off);
  EXPECT_LE(*off - killed, milliseconds(250));
  EXPECT_EQ(rig.motions(), motions);
  ReportTimeToSafe(TimeToSafe(rig, killed));
  ReportNote("enable dropped after " + InMs(*off - killed));
  ASSERT_TRUE(rig.Restart());
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

TEST(FaultMatrix, M13_TheStopLineDoesNotWaitForABusyLink) {
  for (const milliseconds later : {milliseconds(3), milliseconds(12), milliseconds(26)}) {
    FaultRig rig(FaultRig::With("M13"));
    ASSERT_TRUE(rig.Operate([&] { return rig.fault_time().has_value(); }, seconds(60)));
    const nanoseconds pressed = rig.Now() + later;
    rig.chain().PressEstopAt(pressed);
    ASSERT_TRUE(rig.RunUntil([&] { return rig.Now() > pressed && !rig.chain().Pin(InterlockOutput::kQuickStop); }));
    EXPECT_LE(rig.Now() - pressed, kTick);
    ReportNote("ordered after " + InMs(rig.Now() - pressed));
    static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(10)));
    ReportTimeToSafe(TimeToSafe(rig, pressed));
    rig.chain().ReleaseEstopAt(rig.Now());
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kChainOpen, CauseCode::kAxisLink}}), "");
  }
}

}  // namespace
}  // namespace annulus::faults
