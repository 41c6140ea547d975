// Rows B1 … B10: the ring on USB, up to the file and the next scan.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr double kTrueRangeMm = 450.0;  ///< Of the cylinder.
constexpr double kRoundingMm = 0.02;
constexpr nanoseconds kTwoPeriods = 2 * kLevelPeriod;

FaultRigOptions WithBoard(const std::string& row, std::size_t board) {
  FaultRigOptions options = FaultRig::With(row);
  for (sim::Fault& fault : options.plan.faults) fault.args.Set(sim::FaultArg::kBoard, static_cast<double>(board));
  return options;
}

/// What went wrong on all ports.
sim::UsbFaultLog SumOf(FaultRig& rig) {
  sim::UsbFaultLog sum;
  for (std::size_t board = 0; board < sim::BoothDevices::kBoards; ++board) {
    const sim::UsbFaultLog& log = rig.injector().usb().log(board);
    sum.shortened += log.shortened;
    sum.kept_bytes += log.kept_bytes;
    sum.emptied += log.emptied;
    sum.lengthened += log.lengthened;
    sum.damaged += log.damaged;
    sum.timed_out += log.timed_out;
    sum.stalls += log.stalls;
    sum.halts_cleared += log.halts_cleared;
    sum.cancels_completed += log.cancels_completed;
  }
  return sum;
}

TEST(FaultMatrix, B1_ABoardThatIsGoneInMidScanStopsItWithinTwoLevelsAndKeepsWhatWasTaken) {
  Longest safe;
  nanoseconds worst{0};
  for (std::size_t board = 0; board < sim::BoothDevices::kBoards; ++board) {
    FaultRigOptions options = WithBoard("B1", board);
    const std::uint64_t level = 1 + (board * 17) % 47;
    options.plan.faults.front().at.number = level;
    FaultRig rig(std::move(options));
    ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
    const nanoseconds took = WhenStopped(rig) - *rig.fault_time();
    worst = std::max(worst, took);
    EXPECT_LE(took, kTwoPeriods) << board;
    EXPECT_THAT(rig.status().causes.front().text, HasSubstr("ring board " + std::to_string(1001 + board)));
    EXPECT_TRUE(rig.RunUntil([&] { return rig.status().scan.has_value(); }, seconds(2)));
    // What was on its way when the plug was pulled: no more than the pipeline holds.
    EXPECT_GE(rig.levels("scan.mcap"), level + 1);
    EXPECT_LE(rig.levels("scan.mcap"), level + 4);
    EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "") << board;
  }
  ReportNote("stopped after at most " + InMs(worst));
}

/// Until the ring is whole again though nobody has done anything, from `back` on.
nanoseconds ReopenedAfter(FaultRig& rig, nanoseconds back) {
  const auto whole = [&] {
    return rig.Now() > back && rig.injector().usb_host_model().open_ports() == sim::BoothDevices::kBoards &&
           rig.ring().state() == RangeRing::State::kIdle;
  };
  return rig.RunUntil(whole, seconds(20)) ? rig.Now() - back : nanoseconds::max();
}

TEST(FaultMatrix, B2_ABoardThatIsBackAfter300MillisecondsIsOpenedAgainAndNothingResumes) {
  FaultRig rig(FaultRig::With("B2"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  const nanoseconds back = *rig.fault_time() + milliseconds(300);
  const nanoseconds took = ReopenedAfter(rig, back);
  EXPECT_LE(took, seconds(3));
  ReportNote("opened again after " + InMs(took));
  const std::size_t motions = rig.motions();
  rig.Pass(seconds(5));
  EXPECT_EQ(rig.state(), ScanState::kFault);
  EXPECT_EQ(rig.motions(), motions);
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, B3_TwelveBoardsGoneAtOnceAreOneCause) {
  Longest safe;
  for (const double ending : {0.0, 1.0, 2.0, 3.0}) {
    FaultRigOptions options = FaultRig::With("B3");
    options.plan.faults.front().args.Set(sim::FaultArg::kEnding, ending);
    FaultRig rig(std::move(options));
    ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
    rig.Pass(milliseconds(300));
    ASSERT_EQ(rig.status().causes.size(), 1U) << rig.Told();
    EXPECT_THAT(rig.status().causes.front().text, HasSubstr("all 12 boards"));
    EXPECT_EQ(rig.watch().shown().size(), 1U);
    EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "") << ending;
  }
}

TEST(FaultMatrix, B4_SpoiledPacketsAreCountedExactlyAndNeverBelieved) {
  FaultRigOptions options = FaultRig::With("B4");
  options.booth.board.split_share = 0.0;  // one transfer is one frame, so that counts can be exact
  FaultRig rig(std::move(options));
  EXPECT_EQ(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; }), true) << rig.Told();
  const sim::UsbFaultLog log = SumOf(rig);
  EXPECT_GT(log.shortened, 0U);
  EXPECT_GT(log.emptied, 0U);
  EXPECT_GT(log.lengthened, 0U);
  EXPECT_GT(log.damaged, 0U);
  const RingCounters counted = rig.status().scan->summary.ring;
  EXPECT_EQ(counted.lost_frames, log.shortened + log.emptied + log.damaged);
  EXPECT_EQ(FalseRanges(RecordedScan(rig), kTrueRangeMm, kRoundingMm), 0U);
  ReportNote(std::to_string(counted.lost_frames) + " frames lost, all counted, none believed");
  EXPECT_EQ(BearsScan(rig), "");
}

TEST(FaultMatrix, B4_ABoardThatSendsMostlyRubbishStopsTheScan) {
  FaultRig rig(FaultRig::With("B4_limit"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorData}, safe), "");
  EXPECT_EQ(FalseRanges(RecordedScan(rig), kTrueRangeMm, kRoundingMm), 0U);
}

TEST(FaultMatrix, B5_AStallIsClearedAndTheScanGoesOn) {
  FaultRig rig(FaultRig::With("B5"));
  EXPECT_EQ(BearsScan(rig), "");
  EXPECT_GE(SumOf(rig).stalls, 1U);
  EXPECT_EQ(FalseRanges(RecordedScan(rig), kTrueRangeMm, kRoundingMm), 0U);
}

TEST(FaultMatrix, B5_AnEndpointThatStaysHaltedIsAFaultWithin500Milliseconds) {
  FaultRig rig(FaultRig::With("B5_stays"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  EXPECT_LE(WhenStopped(rig) - *rig.fault_time(), milliseconds(500));
  EXPECT_EQ(SumOf(rig).halts_cleared, 1U);
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorBus, CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, B6_OfTransfersThatTimedOutOnlyWholeFramesAreUsed) {
  FaultRig rig(FaultRig::With("B6"));
  EXPECT_EQ(BearsScan(rig), "");
  EXPECT_GT(SumOf(rig).timed_out, 50U);
  EXPECT_EQ(FalseRanges(RecordedScan(rig), kTrueRangeMm, kRoundingMm), 0U);
}

TEST(FaultMatrix, B7_AStopWaitsForEveryTransferWhateverItEndsAs) {
  for (const std::uint64_t level : {0U, 3U, 11U, 29U, 30U, 44U, 59U}) {
    FaultRig rig(FaultRig::With("B7"));
    ASSERT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") > level; })) << rig.Told();
    const nanoseconds cancelled = rig.Now();
    ASSERT_TRUE(rig.Cancel());
    ASSERT_TRUE(rig.RunUntil([&] { return rig.state() == ScanState::kIdle && rig.status().job.empty(); }, seconds(2)));
    EXPECT_LE(rig.Now() - cancelled, seconds(1));
    EXPECT_GT(SumOf(rig).cancels_completed, 0U);
    EXPECT_EQ(rig.injector().usb_host_model().leaked_transfers(), 0U);
    EXPECT_EQ(JudgeRun(rig, {}), "") << level;
  }
}

TEST(FaultMatrix, B8_WithoutMemoryForTransfersNothingIsArmed) {
  FaultRig rig(FaultRig::With("B8"));
  EXPECT_EQ(RefusesToArm(rig, "ring", "usbfs_memory_mb"), "");
}

TEST(FaultMatrix, B9_ABoardThatCannotBeOpenedForTwoSecondsIsOpenedWithinThree) {
  FaultRig rig(FaultRig::With("B9"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  const nanoseconds took = ReopenedAfter(rig, *rig.fault_time() + milliseconds(400));
  EXPECT_LE(took, seconds(3));
  ReportNote("opened after " + InMs(took));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, B9_ABoardThatWasUnpluggedAtRestIsFoundAgainByTheNextArming) {
  FaultRig rig(FaultRig::With("B9_idle"));
  EXPECT_EQ(RefusesToArm(rig, "ring", "ring board 1010"), "");
}

TEST(FaultMatrix, B10_TwoBoardsOfOneSerialNumberAreRefusedAndListed) {
  FaultRigOptions options = FaultRig::With("B10");
  options.opens = false;
  FaultRig rig(std::move(options));
  ASSERT_FALSE(rig.opened());
  EXPECT_THAT(rig.opened().message(), HasSubstr("1006"));
  for (UsbPort* port : rig.booth().usb_ports()) EXPECT_EQ(port->in_flight(), 0U);
}

TEST(FaultMatrix, B10_BoardsThatChangedPlacesAreNotArmedAndTheMapIsShown) {
  FaultRig rig(FaultRig::With("B10_swapped"));
  std::string told;
  EXPECT_FALSE(rig.Operate(
      [&] {
        if (rig.status().arm) told = RefusalOf(rig, "ring");
        return rig.state() == ScanState::kScanning;
      },
      seconds(12)));
  EXPECT_FALSE(rig.watch().When(ScanState::kArmed, nanoseconds(0)));
  EXPECT_THAT(told, testing::AllOf(HasSubstr("1003"), HasSubstr("1006")));
  EXPECT_EQ(JudgeRest(rig), "");
  EXPECT_EQ(rig.watch().violations().size(), 0U);
}

}  // namespace
}  // namespace annulus::faults
