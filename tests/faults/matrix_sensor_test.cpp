// Rows S and U4: what the sensors say, and who stands before them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/fit_surface.h"
#include "modeling/measure/section.h"
#include "sim/acting_subject.h"
#include "tests/acquisition/scanner_rig.h"
#include "tests/faults/ring_rows.h"
#include "tests/sim/booth_fixture.h"
#include "tests/sim/cone_subject.h"
#include "tests/sim/cylinder_subject.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

FaultRigOptions OnACone(const std::string& row) {
  FaultRigOptions options = FaultRig::With(row);
  options.booth.subject = std::make_unique<sim::ConeSubject>();
  return options;
}

bool Ended(FaultRig& rig) { return rig.status().scan && rig.state() == ScanState::kIdle; }

std::vector<NoticeCode> NoticesOf(FaultRig& rig) {
  std::vector<NoticeCode> codes;
  const std::optional<ScanResult> scan = rig.status().scan;
  if (scan && scan->quality) {
    for (const QualityNotice& notice : scan->quality->notices) codes.push_back(notice.code);
  }
  return codes;
}

TEST(FaultMatrix, S1_AStuckSensorIsFlaggedWithinTenLevelsAndTheScanGoesOn) {
  FaultRig rig(OnACone("S1"));
  std::uint64_t flagged = 0;
  ASSERT_TRUE(rig.Operate([&] {
    const auto live = rig.status().quality;
    if (flagged == 0 && live && !live->stuck.empty()) flagged = live->levels;
    return Ended(rig);
  })) << rig.Told();
  // The fault begins when level 5 has been taken, the sixth; the first level that it concerns is one of the next.
  EXPECT_GT(flagged, 6U);
  EXPECT_LE(flagged, 6U + 2U + 10U);
  EXPECT_THAT(NoticesOf(rig), Contains(NoticeCode::kSensorsStuck));
  EXPECT_TRUE(rig.status().scan->quality->sensors[47].stuck);
  ReportNote("flagged at level " + std::to_string(flagged) + ", stuck from level 7 on");
  EXPECT_EQ(BearsScan(rig), "");
}

TEST(FaultMatrix, S2_ASensorWithoutReturnMakesAHoleExactlyThere) {
  FaultRig rig(FaultRig::With("S2"));
  ASSERT_TRUE(rig.Operate([&] { return Ended(rig); })) << rig.Told();
  const nanoseconds from = *rig.fault_time();
  const nanoseconds to = from + milliseconds(400);
  const Recording recording = RecordedScan(rig);
  std::size_t holes = 0;
  for (const ScanLevel& level : recording.scan.levels) {
    // Levels at the fault's very edges are not judged: clocks are known to some microseconds.
    if (std::min(std::chrono::abs(level.time - from), std::chrono::abs(level.time - to)) < milliseconds(1)) continue;
    const bool blind = level.time > from && level.time < to;
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      const bool hole = std::isnan(level.readings[sensor].range_mm);
      const bool beside_the_subject = level.readings[sensor].z_mm > sim::kCylinderTopMm;
      if (beside_the_subject) continue;
      EXPECT_EQ(hole, blind && sensor >= 30 && sensor < 33) << level.index << " " << sensor;
      holes += hole ? 1 : 0;
    }
  }
  EXPECT_GE(holes, 3U * 11U);
  EXPECT_EQ(FalseRanges(recording, 450.0, 0.02), 0U) << "a hole is no range";
  EXPECT_EQ(BearsScan(rig), "");
}

TEST(FaultMatrix, S3_SpikesAreToldAndDoNotSpoilTheGirth) {
  FaultRigOptions options = FaultRig::With("S3");
  options.booth.beam.noise_sigma_mm = 0.5;
  FaultRig rig(std::move(options));
  ASSERT_TRUE(rig.Operate([&] { return Ended(rig); })) << rig.Told();
  const ScanQuality quality = *rig.status().scan->quality;
  EXPECT_NEAR(quality.spike_rate, 0.01, 0.004);
  const auto fit = FitSurface(BuildSamples(RecordedScan(rig).scan), {}, {});
  ASSERT_TRUE(fit) << fit.error().Text();
  const auto body = MeasuredSurface::FromModel(fit->model);
  ASSERT_TRUE(body) << body.error().Text();
  const auto section = SectionAt(*body, 1550.0);
  ASSERT_TRUE(section) << section.error().Text();
  // ISO 20685-1 lets a small girth be wrong by 4 mm.
  EXPECT_NEAR(section->tape.value, 2.0 * std::numbers::pi * sim::kCylinderRadiusMm, 4.0);
  ReportNote("spike rate " + std::to_string(quality.spike_rate) + ", girth wrong by " +
             std::to_string(section->tape.value - 2.0 * std::numbers::pi * sim::kCylinderRadiusMm) + " mm");
  EXPECT_EQ(BearsScan(rig), "");
}

/// These sensors are dead from the beginning until the scan is over.
FaultRigOptions WithDead(const std::vector<int>& sensors) {
  FaultRigOptions options = FaultRig::With("S5");
  const sim::Fault one = options.plan.faults.front();
  options.plan.faults.clear();
  for (const int sensor : sensors) {
    options.plan.faults.push_back(one);
    options.plan.faults.back().args.Set(sim::FaultArg::kSensor, sensor);
  }
  return options;
}

TEST(FaultMatrix, S5_OneOrTwoDeadSensorsArePutUpWithMoreOrNeighboursStopTheScan) {
  for (const std::vector<int>& dead : {std::vector<int>{17}, {17, 90}, {0, 178}}) {
    FaultRig rig(WithDead(dead));
    ASSERT_TRUE(rig.Operate([&] { return Ended(rig); })) << rig.Told();
    EXPECT_THAT(NoticesOf(rig), Contains(NoticeCode::kSensorsDead));
    EXPECT_EQ(rig.status().scan->quality->sensors_verdict, SensorsVerdict::kDegraded);
    EXPECT_EQ(BearsScan(rig), "") << dead.front();
  }
  Longest safe;
  for (const std::vector<int>& dead : {std::vector<int>{17, 18}, {179, 0}, {10, 60, 110}, {5, 40, 75, 110, 145}}) {
    FaultRig rig(WithDead(dead));
    ASSERT_TRUE(rig.Operate([&] { return IsStopped(rig) && rig.Now() > seconds(2); })) << rig.Told();
    ASSERT_EQ(rig.status().causes.size(), 1U) << rig.Told();
    for (const int sensor : dead) {
      EXPECT_THAT(rig.status().causes.front().text, HasSubstr(std::to_string(sensor)));
    }
    ASSERT_TRUE(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(30)));
    EXPECT_EQ(JudgeRun(rig, {{CauseCode::kSensorsDead}}), "") << dead.front();
  }
}

TEST(FaultMatrix, S6_ADeadBoardIsRefused) {
  FaultRig rig(FaultRig::With("S6"));
  ASSERT_TRUE(rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed; })) << rig.Told();
  rig.Pass(milliseconds(100));
  // So many in a row might be the gap beside an arm: they are told after 80 levels.
  ArmRequest longer;
  longer.plan = ScannerRig::ShortPlan();
  longer.plan.z_bottom_mm = 600.0;
  longer.out = "scan.mcap";
  longer.header.ring_radius_mm = 600.0;
  longer.header.calibration = RingCalibration::Ideal(600.0);
  ASSERT_TRUE(rig.scanner().OrderArm(longer));
  ASSERT_TRUE(rig.RunUntil(ScanState::kArmed, seconds(5))) << rig.Told();
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil(ScanState::kFault, seconds(30))) << rig.Told();
  EXPECT_LE(rig.levels("scan.mcap"), 82U);
  const auto stopped = rig.watch().When(ScanState::kStopping, seconds(2));
  ASSERT_TRUE(stopped);
  ReportTimeToSafe(TimeToSafe(rig, *stopped));
  EXPECT_EQ(JudgeRun(rig, {{CauseCode::kSensorsDead}}), "");
}

TEST(FaultMatrix, S8_AClockThatStandsOrJumpsStopsTheScan) {
  Longest safe;
  for (const char* row : {"S8", "S8_jump"}) {
    FaultRig rig(OnACone(row));
    EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorData, CauseCode::kSensorLost}, safe), "") << row;
  }
}

/// The largest error of a reading's height on the cone.
double WorstHeight(const Recording& recording) {
  double worst = 0.0;
  for (const ScanLevel& level : recording.scan.levels) {
    for (const RangeReading& reading : level.readings) {
      if (!std::isfinite(reading.range_mm)) continue;
      worst = std::max(worst, std::abs(reading.z_mm - sim::ConeSubject::HeightOf(600.0, reading.range_mm)));
    }
  }
  return worst;
}
/// Half a step of range, 0.01 mm, is 0.05 mm of height; the rest is what two clocks are known to at full speed.
constexpr double kHeightMm = 0.12;

TEST(FaultMatrix, S8_AClockThatWrapsIsUnwrapped) {
  for (const double in_s : {3.0, 5.0, 7.0, 11.0}) {
    FaultRigOptions options = OnACone("S8_wrap");
    options.plan.faults.front().args.Set(sim::FaultArg::kInS, in_s);
    FaultRig rig(std::move(options));
    EXPECT_EQ(BearsScan(rig), "") << in_s;
    EXPECT_LE(WorstHeight(RecordedScan(rig)), kHeightMm) << in_s;
  }
}

TEST(FaultMatrix, S9_ABoardOfAnotherProtocolIsRefusedAndBothVersionsAreNamed) {
  {
    FaultRigOptions options = FaultRig::With("S9");
    options.opens = false;
    FaultRig rig(std::move(options));
    ASSERT_FALSE(rig.opened());
    EXPECT_THAT(rig.opened().message(), HasSubstr("9"));
    EXPECT_THAT(rig.opened().message(), HasSubstr("protocol"));
  }
  // Or it comes back as another one: the fault stays until the old one is there again.
  FaultRig rig(FaultRig::With("S9_firmware"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  rig.Pass(seconds(2));
  static_cast<void>(rig.Acknowledge(CauseRole::kOperator));
  rig.Pass(seconds(2));
  EXPECT_EQ(rig.state(), ScanState::kFault) << rig.Told();
  EXPECT_FALSE(rig.watch().When(ScanState::kArmed, *rig.fault_time()));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, S10_AnEmitterFaultSwitchesTheEmittersOffAndStops) {
  FaultRig rig(FaultRig::With("S10"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  const auto off = WhenSignal(rig, sim::ChainSignal::kEmitterSupply, false, *rig.fault_time());
  ASSERT_TRUE(off);
  // The bit comes with the board's next level.
  EXPECT_LE(*off - *rig.fault_time(), kLevelPeriod + milliseconds(10) + 2 * kControlTick);
  EXPECT_LE(*off - WhenStopped(rig), kControlTick + milliseconds(10));
  ReportNote("emitters off " + InMs(*off - *rig.fault_time()) + " after the fault, " + InMs(*off - WhenStopped(rig)) +
             " after it was known");
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kEmitter}, safe), "");
}

TEST(FaultMatrix, S10_ABoardWhoseSupervisionSaysNothingStopsTheScan) {
  FaultRig rig(FaultRig::With("S10_silent"));
  ASSERT_TRUE(ScanIntoFault(rig)) << rig.Told();
  const auto off = WhenSignal(rig, sim::ChainSignal::kEmitterSupply, false, *rig.fault_time());
  ASSERT_TRUE(off);
  EXPECT_LE(*off - *rig.fault_time(), seconds(1));
  Longest safe;
  EXPECT_EQ(StopsScan(rig, {CauseCode::kSensorLost}, safe), "");
}

TEST(FaultMatrix, S11_DataThatComesLateIsPlacedByItsTimeStamp) {
  double worst = 0.0;
  for (const double levels : {1.0, 2.0, 3.0}) {
    // It gets later by one level after the other: two levels without a word are a board that is lost.
    FaultRigOptions options = OnACone("S11");
    std::erase_if(options.plan.faults,
                  [&](const sim::Fault& fault) { return fault.Value(sim::FaultArg::kLevels) > levels; });
    FaultRig rig(std::move(options));
    EXPECT_EQ(BearsScan(rig), "") << levels;
    const Recording recording = RecordedScan(rig);
    EXPECT_EQ(recording.scan.levels.size(), FaultRig::WholeScan());
    worst = std::max(worst, WorstHeight(recording));
  }
  EXPECT_LE(worst, kHeightMm);
  ReportNote("worst height error " + std::to_string(worst).substr(0, 5) + " mm, of it 0.05 mm rounding of ranges");
}

/// When this rig's scan takes its level `number`, in s of the simulation.
double TimeOfLevel(std::uint64_t number) {
  FaultRig rig;
  EXPECT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") > number; })) << rig.Told();
  return static_cast<double>(rig.Now().count()) * 1e-9;
}

FaultRigOptions WithSubject(std::unique_ptr<sim::Subject> subject) {
  FaultRigOptions options = FaultRig::Defaults();
  options.booth.subject = std::move(subject);
  return options;
}
std::unique_ptr<sim::Subject> Cylinder() {
  return std::make_unique<sim::CylinderSubject>(sim::kCylinderRadiusMm, sim::kCylinderTopMm);
}

/// The scan ends as any other, is to be repeated, and the notice with its advice is there.
void ExpectRepeat(FaultRig& rig, NoticeCode code) {
  EXPECT_THAT(NoticesOf(rig), Contains(code));
  const ScanQuality quality = *rig.status().scan->quality;
  EXPECT_EQ(quality.verdict, QualityVerdict::kRepeat) << TextFromQuality(quality);
  for (const QualityNotice& notice : quality.notices) EXPECT_THAT(notice.advice, testing::Not(IsEmpty()));
}

TEST(FaultMatrix, U4_APersonWhoLeavesIsSeenAndTheScanIsToBeRepeated) {
  FaultRig rig(WithSubject(std::make_unique<sim::WalkingSubject>(Cylinder(), std::nullopt, TimeOfLevel(20))));
  bool left = false;
  ASSERT_TRUE(rig.Operate([&] {
    left = left || (rig.status().quality && rig.status().quality->left);
    return Ended(rig);
  })) << rig.Told();
  EXPECT_TRUE(left) << "while it was still being taken";
  ExpectRepeat(rig, NoticeCode::kLeft);
}

TEST(FaultMatrix, U4_APersonWhoStepsAsideIsSeenAndTheScanIsToBeRepeated) {
  sim::StepAside step;
  step.at_s = TimeOfLevel(29);
  FaultRig rig(WithSubject(std::make_unique<sim::WalkingSubject>(Cylinder(), step, std::nullopt)));
  ASSERT_TRUE(rig.Operate([&] { return Ended(rig); })) << rig.Told();
  ExpectRepeat(rig, NoticeCode::kMoved);
  EXPECT_EQ(JudgeRest(rig) + JudgeRecording(rig, "scan.mcap"), "");
}

TEST(FaultMatrix, U4_AnArmHeldOutIsSeenAndNamed) {
  sim::HeldOutArm arm;
  arm.at_s = TimeOfLevel(29);
  for (Eigen::Vector3d* joint : {&arm.shoulder, &arm.elbow, &arm.hand}) joint->z() += 200.0;
  FaultRig rig(WithSubject(std::make_unique<sim::ArmRaisingSubject>(Cylinder(), Cylinder(), arm)));
  ASSERT_TRUE(rig.Operate([&] { return Ended(rig); })) << rig.Told();
  EXPECT_THAT(NoticesOf(rig), Contains(NoticeCode::kPartMoved));
  EXPECT_NE(rig.status().scan->quality->verdict, QualityVerdict::kGood);
  EXPECT_EQ(JudgeRest(rig) + JudgeRecording(rig, "scan.mcap"), "");
}

}  // namespace
}  // namespace annulus::faults
