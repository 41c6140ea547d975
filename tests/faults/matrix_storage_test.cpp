// Rows D1 … D5: the disk under a scan. A disk after a crash: tests/crash.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// How scans went of which one call of the disk failed.
struct Walk {
  int refused = 0;     ///< Before anything moved.
  int stopped = 0;     ///< In mid-scan.
  int incomplete = 0;  ///< At the very end: all is there, but not said to be.
  std::string wrong;
};

/// The n-th call that the row's fault can concern fails, for n = 1, 2, … until no scan makes as many.
Walk FailEachCall(const std::string& row, Longest& safe) {
  const std::uint64_t stride = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 9;
  Walk walk;
  for (std::uint64_t call = 1; walk.wrong.empty(); call += call < 12 ? 1 : stride) {
    FaultRigOptions options = FaultRig::With(row);
    options.plan.faults.front().at.number = call;
    FaultRig rig(std::move(options));
    const auto refused = [&] { return rig.status().arm && !rig.status().arm->passed(); };
    const auto stopped = [&] { return rig.Now() > seconds(2) && IsStopped(rig); };
    const auto ended = [&] {
      return rig.status().scan && rig.status().job.empty() && !rig.status().scan->recording.empty();
    };
    if (!rig.Operate([&] { return refused() || ended() || stopped(); }, seconds(60))) {
      walk.wrong = "call " + std::to_string(call) + ": " + rig.Told();
      break;
    }
    static_cast<void>(rig.RunUntil([&] { return rig.status().job.empty(); }, seconds(5)));
    rig.Pass(milliseconds(50));  // a fault of the disk is known at the next tick
    if (!rig.fault_time()) return walk;
    Expected expected;
    if (refused()) {
      ++walk.refused;
      if (rig.watch().When(ScanState::kArmed, nanoseconds(0))) walk.wrong += "armed all the same; ";
    } else if (rig.state() == ScanState::kFault) {
      ++walk.stopped;
      expected.causes = {CauseCode::kStorage};
      safe.Note(TimeToSafe(rig, *rig.fault_time()));
    } else {
      ++walk.incomplete;
      if (rig.status().scan->complete) walk.wrong += "the scan is said to be complete; ";
    }
    if (const std::string wrong = JudgeRun(rig, expected); !wrong.empty()) {
      walk.wrong += "call " + std::to_string(call) + ": " + wrong;
    }
  }
  return walk;
}

std::string NoteOf(const Walk& walk) {
  return std::to_string(walk.refused) + " not armed, " + std::to_string(walk.stopped) + " stopped, " +
         std::to_string(walk.incomplete) + " not complete";
}

TEST(FaultMatrix, D1_AFullDiskAtAnyWriteIsNotArmedOrStopsAndKeepsEveryLevelBefore) {
  Longest safe;
  const Walk walk = FailEachCall("D1", safe);
  EXPECT_EQ(walk.wrong, "");
  EXPECT_GE(walk.refused, 2);
  EXPECT_GE(walk.stopped, 3);
  ReportNote(NoteOf(walk));
}

TEST(FaultMatrix, D1_WithoutRoomForFiveScansNothingIsArmed) {
  FaultRig rig(FaultRig::With("D1_low"));
  EXPECT_EQ(RefusesToArm(rig, "disk", "(five scans)"), "");
}

TEST(FaultMatrix, D2_AnErrorOrAShortWriteAtAnyCallIsFinalAndStops) {
  Longest safe;
  for (const char* row : {"D2", "D2_short"}) {
    const Walk walk = FailEachCall(row, safe);
    EXPECT_EQ(walk.wrong, "") << row;
    EXPECT_GE(walk.stopped, 3);
    ReportNote(NoteOf(walk));
  }
}

TEST(FaultMatrix, D3_ASyncThatFailedOnceIsNeverTakenForASuccess) {
  Longest safe;
  const Walk walk = FailEachCall("D3", safe);
  EXPECT_EQ(walk.wrong, "");
  EXPECT_GE(walk.stopped + walk.incomplete, 3);
  ReportNote(NoteOf(walk));
}

TEST(FaultMatrix, D4_ASyncOfTwoSecondsIsToldAndCostsNoLevel) {
  std::atomic<std::int64_t> now{0};  // of the simulation, for the disk's thread
  FaultRigOptions options = FaultRig::With("D4");
  options.scanner.recording.disk = DiskWriterMode::kThread;
  options.scanner.recording.disk_clock = [&now] { return nanoseconds(now.load()); };
  FaultRig rig(std::move(options));
  rig.on_tick = [&] { now = rig.Now().count(); };
  bool told = false;
  ASSERT_TRUE(rig.Operate([&] {
    for (const ScanWarning& one : rig.status().warnings) told = told || one.code == WarningCode::kDiskSlow;
    return rig.status().scan && rig.state() == ScanState::kIdle;
  })) << rig.Told();
  EXPECT_TRUE(told) << rig.Told();
  EXPECT_EQ(BearsScan(rig), "");
  EXPECT_EQ(rig.levels("scan.mcap"), FaultRig::WholeScan());
  ReportNote("0 levels lost");
}

TEST(FaultMatrix, D5_ADiskThatIsReadOnlyIsNotArmed) {
  FaultRig rig(FaultRig::With("D5"));
  EXPECT_EQ(RefusesToArm(rig, "disk", "Read-only"), "");
}

TEST(FaultMatrix, D5_ADiskThatBecomesReadOnlyStopsTheScan) {
  FaultRig rig(FaultRig::With("D5_scan"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kStorage}, safe), "");
}

}  // namespace
}  // namespace annulus::faults
