#include "acquisition/scanner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acquisition/recording.h"
#include "acquisition/supervised_axis.h"
#include "tests/acquisition/scanner_rig.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

TEST(Scanner, TakesABodyFromPowerUpToTheFileAndIsIdleAgain) {
  ScannerRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  ASSERT_TRUE(rig.RunUntil(ScanState::kIdle, std::chrono::seconds(1))) << rig.Told();
  const ScanResult scan = *rig.scanner_->status().scan;
  ASSERT_TRUE(scan.status) << scan.status.error().Text();
  EXPECT_TRUE(scan.complete) << scan.summary.BriefReport();
  EXPECT_TRUE(rig.scanner_->status().homed);
  const auto recording = ReadWholeRecording(rig.storage_, "scan.mcap");
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->scan.levels.size(), ScannerRig::ShortPlan().TotalLevels());
  EXPECT_EQ(rig.booth_.drive().state(), DriveState::kSwitchOnDisabled);
}

TEST(Scanner, DoesWithoutALostReferenceBoardAndFindsItAgainWhenItIsArmed) {
  sim::BoothOptions options = ScannerRig::Options();
  options.reference = StandardReferenceSensors();
  ScannerRig rig(std::move(options));
  sim::RingBoardModel& board = rig.booth_.board(sim::BoothDevices::kReference);
  const auto warned = Contains(Field(&ScanWarning::text, HasSubstr("reference board 1013 gives no readings")));
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  EXPECT_THAT(rig.scanner_->status().warnings, Not(warned));
  board.UnplugAt(rig.clock_.Now() + seconds(3));
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  const ScanResult scan = *rig.scanner_->status().scan;
  ASSERT_TRUE(scan.status) << scan.status.error().Text();
  EXPECT_TRUE(scan.complete) << scan.summary.BriefReport();
  EXPECT_THAT(scan.summary.reference_trouble, HasSubstr("unplugged"));
  EXPECT_GT(scan.summary.reference_levels, 0U);
  EXPECT_LT(scan.summary.reference_levels, scan.summary.levels);
  EXPECT_THAT(rig.scanner_->status().warnings, warned);
  EXPECT_TRUE(rig.scanner_->status().causes.empty()) << rig.Told();
  const auto recording = ReadWholeRecording(rig.storage_, "scan.mcap");
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_TRUE(recording->report.clean());
  ASSERT_TRUE(recording->scan.header.reference);
  EXPECT_EQ(recording->scan.header.reference->firmware_version, "1.2.0");

  ASSERT_TRUE(rig.RunUntil(ScanState::kIdle, seconds(1))) << rig.Told();
  board.PlugIn();
  ArmRequest again = rig.Request();
  again.out = "again.mcap";
  ASSERT_TRUE(rig.scanner_->OrderArm(again));
  ASSERT_TRUE(rig.RunUntil(ScanState::kArmed, seconds(10))) << rig.Told();
  EXPECT_THAT(rig.scanner_->status().warnings, Not(warned));
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan->number == 2; })) << rig.Told();
  const ScanSummary second = rig.scanner_->status().scan->summary;
  EXPECT_EQ(second.reference_levels, second.levels);
}

TEST(Scanner, AnEmitterFaultOfTheReferenceBoardStopsAsAnyBoardsDoes) {
  sim::BoothOptions options = ScannerRig::Options();
  options.reference = StandardReferenceSensors();
  ScannerRig rig(std::move(options));
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  sim::BoardFault fault;
  fault.kind = sim::BoardFaultKind::kEmitterFault;
  fault.from = rig.clock_.Now() + seconds(3);
  rig.booth_.board(sim::BoothDevices::kReference).faults().Add(fault);
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  ASSERT_FALSE(rig.scanner_->status().causes.empty());
  EXPECT_EQ(rig.scanner_->status().causes.front().code, CauseOf(RingTrouble::kEmitter));
}

/// A scan of a ring at `temperature_c` with a calibration that knows, or does not know, what that does.
ArmRequest CalibratedAt20(const ScannerRig& rig, double range_mm_per_c) {
  ArmRequest request = rig.Request();
  request.header.calibration.certificate = "sha256:1";
  request.header.calibration.reference_c = 20.0;
  request.header.calibration.range_mm_per_c = range_mm_per_c;
  return request;
}

TEST(Scanner, RecordsTheCalibrationAtTheRingsTemperature) {
  sim::BoothOptions options = ScannerRig::Options();
  options.board.temperature_c = 35.0;
  ScannerRig rig(std::move(options));
  ASSERT_NO_FATAL_FAILURE(rig.ToHomed());
  ASSERT_TRUE(rig.scanner_->OrderArm(CalibratedAt20(rig, 0.02)));
  ASSERT_TRUE(rig.RunUntil(ScanState::kArmed, seconds(10))) << rig.Told();
  EXPECT_THAT(rig.scanner_->status().warnings, Not(Contains(Field(&ScanWarning::code, WarningCode::kRingTemperature))));
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  const auto recording = ReadWholeRecording(rig.storage_, "scan.mcap");
  ASSERT_TRUE(recording) << recording.error().Text();
  const ScanHeader& header = recording->scan.header;
  ASSERT_TRUE(header.machine.ring_temperature_c);
  EXPECT_NEAR(*header.machine.ring_temperature_c, 35.0, 1.0);
  EXPECT_EQ(header.calibration.reference_c, *header.machine.ring_temperature_c);
  for (const SensorCalibration& sensor : header.calibration.sensors) {
    EXPECT_NEAR(sensor.range_offset_mm, 0.02 * (header.calibration.reference_c - 20.0), 1e-9);
  }
  EXPECT_EQ(header.calibration.certificate, "sha256:1");
}

TEST(Scanner, WarnsOfARingThatIsFarFromTheTemperatureOfItsCalibration) {
  const auto warned = Contains(HasSubstr("it was calibrated at 20"));
  for (const double temperature_c : {35.0, 22.0}) {
    sim::BoothOptions options = ScannerRig::Options();
    options.board.temperature_c = temperature_c;
    ScannerRig rig(std::move(options));
    ASSERT_NO_FATAL_FAILURE(rig.ToHomed());
    ASSERT_TRUE(rig.scanner_->OrderArm(CalibratedAt20(rig, 0.0)));
    ASSERT_TRUE(rig.RunUntil(ScanState::kArmed, seconds(10))) << rig.Told();
    std::vector<std::string> warnings;
    for (const ScanWarning& one : rig.scanner_->status().warnings) warnings.push_back(one.text);
    if (temperature_c < 30.0) {
      EXPECT_THAT(warnings, Not(warned));
      continue;
    }
    EXPECT_THAT(warnings, warned);
    ASSERT_TRUE(rig.Start()) << "it stops nothing";
    ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
    const auto recording = ReadWholeRecording(rig.storage_, "scan.mcap");
    ASSERT_TRUE(recording) << recording.error().Text();
    std::vector<std::string> events;
    for (const RecordedEvent& event : recording->events) events.push_back(event.text);
    EXPECT_THAT(events, warned) << "and the recording keeps it";
    EXPECT_EQ(recording->scan.header.calibration.sensors, RingCalibration::Ideal(600.0).sensors);
  }
}

TEST(Scanner, AnIdealRingWarnsOfNoTemperature) {
  sim::BoothOptions options = ScannerRig::Options();
  options.board.temperature_c = 40.0;
  ScannerRig rig(std::move(options));
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  EXPECT_THAT(rig.scanner_->status().warnings, Not(Contains(Field(&ScanWarning::code, WarningCode::kRingTemperature))));
}

}  // namespace
}  // namespace annulus
