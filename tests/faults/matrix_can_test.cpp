// Rows B11 … B20: the ring on CAN, up to the file and the next scan.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tests/faults/ring_rows.h"
#include "tests/sim/cone_subject.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// Until the ring is idle and answers again though nobody has done anything, from `back` on.
nanoseconds BackAfter(FaultRig& rig, nanoseconds back) {
  const auto bound = [&] {
    return rig.Now() > back && rig.ring().state() == RangeRing::State::kIdle &&
           rig.injector().can().log(0).reopened > 0;
  };
  return rig.RunUntil(bound, seconds(20)) ? rig.Now() - back : nanoseconds::max();
}

TEST(FaultMatrix, B11_BusOffStopsTheScanAndIsRestartedSlowlyAndSeldomAndResumesNothing) {
  FaultRig rig(FaultRig::OnCan("B11"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorBus, CauseCode::kSensorLost}, safe), "");
  const auto& restarts = rig.injector().can().log(0).restarts;
  EXPECT_LE(restarts.size(), 5U);
  for (std::size_t i = 1; i < restarts.size(); ++i) EXPECT_GE(restarts[i] - restarts[i - 1], seconds(1));
  // Here the boards keep the bus to themselves, and our controller stays on it; what bounds its restarts is shown by
  // CanRangeRingFaults.B11_*.
  ReportNote(std::to_string(restarts.size()) + " restarts; their limits: unit_firmware_iface B11_*");
}

TEST(FaultMatrix, B12_AFloodOfWarningsIsLoggedSparingly) {
  testing::internal::CaptureStderr();
  FaultRig rig(FaultRig::OnCan("B12"));
  const std::string wrong = BearsScan(rig);
  std::istringstream log(testing::internal::GetCapturedStderr());
  int lines = 0;
  for (std::string line; std::getline(log, line);) ++lines;
  EXPECT_EQ(wrong, "");
  EXPECT_LE(lines, 10 * 3);  // two seconds touch three windows
  ReportNote(std::to_string(lines) + " lines for 2,000 reports");
}

TEST(FaultMatrix, B12_APassiveControllerIsNotArmed) {
  FaultRig rig(FaultRig::OnCan("B12_passive"));
  EXPECT_EQ(RefusesToArm(rig, "ring", "error-passive"), "");
}

TEST(FaultMatrix, B13_AFullSendQueueIsPutUpWithBrieflyThenItIsAFault) {
  {
    FaultRig rig(FaultRig::OnCan("B13_short"));
    EXPECT_EQ(BearsScan(rig), "");
  }
  FaultRig rig(FaultRig::OnCan("B13"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  EXPECT_THAT(rig.status().causes.front().text, HasSubstr("transmit queue is full"));
  EXPECT_LE(WhenStopped(rig) - *rig.fault_time(), 2 * kLevelPeriod);
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorBus}, safe), "");
}

TEST(FaultMatrix, B14_AnInterfaceThatGoesAwayIsBoundAgainWithinTwoSeconds) {
  Longest safe;
  for (const char* row : {"B14", "B14_gone"}) {
    FaultRig rig(FaultRig::OnCan(row));
    ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
    const nanoseconds took = BackAfter(rig, *rig.fault_time() + milliseconds(700));
    EXPECT_LE(took, seconds(2)) << row;
    ReportNote("bound again after " + InMs(took));
    EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorBus}, safe), "") << row;
  }
}

/// Readings whose height is not the one at which their range is to be had on the cone.
std::size_t Displaced(const Recording& recording) {
  // Half a step of range, 0.02 mm, is 0.1 mm of height; the rest is the clocks'.
  constexpr double kWithinMm = 0.2;
  std::size_t count = 0;
  for (const ScanLevel& level : recording.scan.levels) {
    for (const RangeReading& reading : level.readings) {
      if (!std::isfinite(reading.range_mm)) continue;
      if (std::abs(reading.z_mm - sim::ConeSubject::HeightOf(600.0, reading.range_mm)) > kWithinMm) ++count;
    }
  }
  return count;
}

TEST(FaultMatrix, B15_LostRepeatedAndDisplacedFramesPutNoSampleInAWrongPlace) {
  FaultRigOptions options = FaultRig::OnCan("B15");
  options.booth.subject = std::make_unique<sim::ConeSubject>();
  FaultRig rig(std::move(options));
  EXPECT_EQ(BearsScan(rig), "");
  const sim::FaultyCanBus::Log& log = rig.injector().can().log(0);
  EXPECT_GT(log.lost, 0U);
  EXPECT_GT(log.repeated, 50U);
  EXPECT_GT(log.displaced, 50U);
  EXPECT_EQ(Displaced(RecordedScan(rig)), 0U);
  ReportNote(std::to_string(log.lost) + " lost, " + std::to_string(log.repeated) + " repeated, " +
             std::to_string(log.displaced) + " displaced");
}

TEST(FaultMatrix, B15_TooManyLostFramesStopTheScanWithoutAFalseSample) {
  FaultRigOptions options = FaultRig::OnCan("B15_much");
  options.booth.subject = std::make_unique<sim::ConeSubject>();
  FaultRig rig(std::move(options));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorData, CauseCode::kSensorLost, CauseCode::kSensorBus}, safe), "");
  EXPECT_EQ(Displaced(RecordedScan(rig)), 0U);
}

TEST(FaultMatrix, B16_ANodeThatIsSilentFromPowerUpIsNotReadyAfterThreeSeconds) {
  FaultRigOptions options = FaultRig::OnCan("B16");
  options.opens = false;
  FaultRig rig(std::move(options));
  ASSERT_FALSE(rig.opened());
  EXPECT_THAT(rig.opened().message(), HasSubstr("node 7 is not ready"));
  EXPECT_LE(rig.Now(), milliseconds(3500));
}

TEST(FaultMatrix, B17_ABoardThatRestartsStopsTheScan) {
  FaultRig rig(FaultRig::OnCan("B17"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, B17_AnEmergencyMessageStopsTheScanWithItsText) {
  FaultRig rig(FaultRig::OnCan("B17_emergency"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  EXPECT_THAT(rig.status().causes.front().text, HasSubstr("4210h: temperature of the board"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost, CauseCode::kSensorBus, CauseCode::kSensorData}, safe), "");
}

TEST(FaultMatrix, B18_ABabblingNodeStopsTheScanAndLeavesTheSafetyPathAlone) {
  FaultRig rig(FaultRig::OnCan("B18"));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost, CauseCode::kSensorData, CauseCode::kSensorBus}, safe), "");
  // The same with an emergency stop in the midst of it, whatever the worker is doing.
  nanoseconds slowest{0};
  for (const int after_ms : {3, 20, 47, 80}) {
    FaultRig pressed(FaultRig::OnCan("B18"));
    ASSERT_TRUE(pressed.Operate([&] { return pressed.fault_time().has_value(); })) << pressed.Told();
    const nanoseconds press = pressed.Now() + milliseconds(after_ms);
    pressed.chain().PressEstopAt(press);
    ASSERT_TRUE(pressed.RunUntil(
        [&] { return pressed.Now() > press && !pressed.chain().Pin(InterlockOutput::kQuickStop); }, seconds(1)));
    EXPECT_LE(pressed.Now() - press, kControlTick) << after_ms;
    slowest = std::max(slowest, pressed.Now() - press);
    EXPECT_TRUE(pressed.RunUntil(ScanState::kSafe, milliseconds(50)));
  }
  ReportNote("emergency stop mirrored after at most " + InMs(slowest));
}

TEST(FaultMatrix, B19_TwoBoardsUnderOneNodeNumberAreNotArmed) {
  {
    FaultRigOptions options = FaultRig::OnCan("B19");
    options.opens = false;
    FaultRig rig(std::move(options));
    ASSERT_FALSE(rig.opened());
    EXPECT_THAT(rig.opened().message(), HasSubstr("boards 1004, 9004 both have node id 4"));
  }
  FaultRig rig(FaultRig::OnCan("B19_later"));
  std::string told;
  EXPECT_FALSE(rig.Operate(
      [&] {
        if (rig.status().arm) told = RefusalOf(rig, "ring");
        return rig.state() == ScanState::kScanning;
      },
      seconds(12)));
  EXPECT_THAT(told, HasSubstr("9004"));
  EXPECT_FALSE(rig.watch().When(ScanState::kArmed, nanoseconds(0)));
  EXPECT_EQ(JudgeRest(rig), "");
}

TEST(FaultMatrix, B20_WhatTheReceiveQueueLostIsCounted) {
  FaultRig rig(FaultRig::OnCan("B20"));
  EXPECT_EQ(BearsScan(rig), "");
  EXPECT_EQ(rig.injector().can().log(0).overflowed, 5U);
  // The next scan has counters of its own; what the first one lost is in its own summary.
  FaultRig first(FaultRig::OnCan("B20"));
  ASSERT_TRUE(first.Operate([&] { return first.status().scan && first.state() == ScanState::kIdle; }));
  EXPECT_EQ(first.status().scan->summary.ring.overflowed_frames, 5U);
  ReportNote("5 lost, 5 counted");
}

}  // namespace
}  // namespace annulus::faults
