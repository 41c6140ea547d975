// Row U3: cancel in every state and at every level.

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

struct Cancelled {
  std::string wrong;
  nanoseconds took{0};
};

Cancelled CancelNow(FaultRig& rig) {
  const nanoseconds ordered = rig.Now();
  const Status cancelled = rig.Cancel();
  if (!cancelled) return {cancelled.error().Text(), {}};
  std::string wrong;
  if (!rig.RunUntil(ScanState::kIdle, seconds(2))) wrong += "not IDLE within 2 s\n";
  const nanoseconds took = rig.Now() - ordered;
  const bool free = rig.RunUntil([&] { return rig.status().job.empty(); }, seconds(2));
  if (!free) wrong += "the job goes on\n";
  if (const auto& scan = rig.status().scan; scan && scan->complete)
    wrong += "a cancelled scan is said to be complete\n";
  wrong += JudgeRun(rig, {});
  return {wrong, took};
}

TEST(FaultMatrix, U3_ACancelEndsInIdleWithin500MsAtEveryLevel) {
  const std::uint64_t step = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 7;
  nanoseconds longest{0};
  int tried = 0;
  for (std::uint64_t level = 1; level <= FaultRig::WholeScan(); level += step, ++tried) {
    FaultRig rig;
    ASSERT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") >= level; })) << rig.Told();
    if (rig.state() != ScanState::kScanning) break;
    const Cancelled outcome = CancelNow(rig);
    EXPECT_EQ(outcome.wrong, "") << "level " << level;
    longest = std::max(longest, outcome.took);
  }
  EXPECT_LE(longest, milliseconds(500));
  ReportTimeToSafe(longest);
  ReportNote(std::to_string(tried) + " levels");
}

TEST(FaultMatrix, U3_ACancelEndsInIdleWithin500MsAtEveryTimeFromPowerUp) {
  const std::int64_t step = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 5;
  nanoseconds longest{0};
  int tried = 0;
  for (std::int64_t tick = 0; tick < 560; tick += step, ++tried) {
    FaultRig rig;
    ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle; })) << rig.Told();
    const nanoseconds from = rig.Now() + tick * milliseconds(10);
    ASSERT_TRUE(rig.Operate([&] { return rig.Now() >= from; }, seconds(20), 0)) << rig.Told();
    const ScanState at = rig.state();
    const Cancelled outcome = CancelNow(rig);
    EXPECT_EQ(outcome.wrong, "") << ScanStateText(at) << " tick " << tick;
    EXPECT_LE(outcome.took, milliseconds(500)) << ScanStateText(at) << " tick " << tick;
    longest = std::max(longest, outcome.took);
  }
  ReportTimeToSafe(longest);
  ReportNote(std::to_string(tried) + " times");
}

TEST(FaultMatrix, U3_ACancelInAnyStateIsNoErrorAndMovesNothing) {
  for (const ScanState state :
       {ScanState::kIdle, ScanState::kArmed, ScanState::kHoming, ScanState::kStopping, ScanState::kJog}) {
    FaultRig rig;
    ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
    const Cancelled outcome = CancelNow(rig);
    EXPECT_EQ(outcome.wrong, "") << ScanStateText(state);
    EXPECT_LE(outcome.took, milliseconds(500)) << ScanStateText(state);
  }
  for (const ScanState state : {ScanState::kSafe, ScanState::kFault}) {
    FaultRig rig;
    ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
    EXPECT_TRUE(rig.Cancel());
    rig.Pass(milliseconds(100));
    EXPECT_EQ(rig.state(), state);
    EXPECT_EQ(JudgeRun(rig, state == ScanState::kSafe ? Expected{} : Expected{{CauseCode::kAxisFault}}), "");
  }
}

}  // namespace
}  // namespace annulus::faults
