// Rows S7 and C1 to C3: exchanged sensors, the calibration file, the reference check.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <tuple>

#include "acquisition/calibration_file.h"
#include "sim/target_subject.h"
#include "station/calibration_gate.h"
#include "station/reference_check.h"
#include "tests/acquisition/scanner_rig.h"
#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

constexpr char kFile[] = "CAL.json";
constexpr char kCheck[] = "check.json";
constexpr std::int64_t kDayNs = 86'400'000'000'000;

/// A booth with a gate as its program has it, and the files that the gate reads.
class CalibratedBooth {
 public:
  CalibratedBooth() {
    clock_.SleepUntil(kSinceTheClockWasSane);
    config_.calibration.file = kFile;
    for (std::uint16_t board = 0; board < 12; ++board) {
      file_.boards.push_back({1001U + board, static_cast<std::uint16_t>(15 * board), 15, 0, ""});
    }
    file_.calibration = RingCalibration::Ideal(600.0);
    file_.calibration.sensors[7].range_offset_mm = 0.25;
    file_.passed = true;
    file_.wall_ns = kNow;
    file_.valid_until_ns = kNow + kDayNs;
    Write();
  }
  void Write() {
    const Status written = WriteCalibrationFile(disk_, kFile, file_);
    EXPECT_TRUE(written) << written.error().Text();
  }
  void WriteCheck(const ReferenceRecord& record) {
    config_.calibration.reference_check = kCheck;
    const std::string text = JsonFromCheck(record).dump();
    const auto bytes = std::as_bytes(std::span(text));
    disk_.files[kCheck] = {bytes.begin(), bytes.end()};
  }
  /// With the calibration that scans are asked for with now, or an ideal ring if there is none.
  FaultRigOptions Options(FaultRigOptions options = FaultRig::Defaults()) {
    gate_ = std::make_unique<CalibrationGate>(config_, disk_);
    gate_->UseClock(clock_);
    options.gate = gate_.get();
    const auto calibration = CalibrationInForce(config_, "body", disk_);
    if (calibration) options.calibration = *calibration;
    return options;
  }

  /// The wall clock's time when a rig starts.
  static constexpr std::chrono::hours kSinceTheClockWasSane{24 * 365 * 20};
  static constexpr std::int64_t kNow =
      (ManualClock::kWallStart + std::chrono::nanoseconds(kSinceTheClockWasSane)).count();
  Config config_ = SimulatedConfig();
  CalibrationFile file_;
  test::TestStorage disk_;
  ManualClock clock_;
  std::unique_ptr<CalibrationGate> gate_;
};

/// What arming says; empty: it passed all checks.
std::string Armed(CalibratedBooth& booth, const std::string& check) {
  FaultRig rig(booth.Options());
  EXPECT_TRUE(rig.Operate([&] { return rig.status().arm.has_value(); })) << rig.Told();
  rig.Pass(milliseconds(200));
  const std::string refusal = RefusalOf(rig, check);
  if (refusal.empty()) {
    EXPECT_TRUE(rig.status().arm->passed()) << rig.Told();
    return {};
  }
  EXPECT_EQ(rig.state(), ScanState::kIdle) << rig.Told();
  EXPECT_FALSE(rig.status().arm->passed());
  EXPECT_EQ(rig.motions() > 0, rig.status().homed) << "homed, and nothing after that";
  EXPECT_EQ(JudgeRest(rig), "");
  EXPECT_FALSE(rig.storage().Exists(rig.recording()));
  return refusal;
}

TEST(FaultMatrix, C1_ARingWithItsCalibrationIsArmedAndItsScanCarriesIt) {
  CalibratedBooth booth;
  FaultRig rig(booth.Options());
  ASSERT_TRUE(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; })) << rig.Told();
  EXPECT_EQ(JudgeRest(rig) + JudgeRecording(rig, "scan.mcap"), "");
  const RingCalibration& carried = RecordedScan(rig).scan.header.calibration;
  EXPECT_EQ(carried.certificate, booth.file_.calibration.certificate);
  EXPECT_EQ(carried.sensors, booth.file_.calibration.sensors);
}

TEST(FaultMatrix, C1_ACalibrationThatIsMissingIsNotArmed) {
  CalibratedBooth booth;
  booth.disk_.files.clear();
  EXPECT_THAT(Armed(booth, "calibration"), HasSubstr("CAL.json"));
  booth.config_.calibration.file.clear();
  booth.config_.calibration.uncalibrated = CalibrationConfig::Uncalibrated::kRefuse;
  EXPECT_EQ(
      Armed(booth, "calibration"),
      "arm a scan: the ring is not calibrated: none was accepted at the console, and [calibration] file names none: "
      "calibrate the ring at the console and accept it, or with 'annulus calibrate' and name its CAL.json; or set "
      "[calibration] uncalibrated = \"mark\", and every result says so");
}

TEST(FaultMatrix, C1_AnUncalibratedRingIsMarkedIfTheBoothWantsThat) {
  CalibratedBooth booth;
  booth.config_.calibration.file.clear();
  booth.config_.calibration.uncalibrated = CalibrationConfig::Uncalibrated::kMark;
  FaultRig rig(booth.Options());
  ASSERT_TRUE(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; })) << rig.Told();
  EXPECT_EQ(JudgeRest(rig) + JudgeRecording(rig, "scan.mcap"), "");
  const RingCalibration& carried = RecordedScan(rig).scan.header.calibration;
  EXPECT_EQ(carried.certificate, "");
  EXPECT_FALSE(carried.uncertainty) << "by which every result says errors_left_out: calibration";
}

TEST(FaultMatrix, C1_ACalibrationThatHasExpiredIsNotArmed) {
  CalibratedBooth booth;
  booth.file_.valid_until_ns = CalibratedBooth::kNow - 1;
  booth.Write();
  EXPECT_EQ(Armed(booth, "calibration"),
            "use the calibration of 2019-12-27T00:00:00Z: it was valid until 2019-12-26T23:59:59Z: calibrate the ring "
            "again");
}

TEST(FaultMatrix, C1_ACalibrationOfAnotherBoardIsNotArmed) {
  CalibratedBooth booth;
  booth.file_.boards[3].serial = 4711;
  booth.Write();
  EXPECT_EQ(Armed(booth, "calibration"),
            "use the calibration of 2019-12-27T00:00:00Z: board 1004 (sensors 45 to 59) is not the one that was "
            "calibrated there (4711): if the board was replaced, calibrate it alone; else put the boards back, or use "
            "this ring's own calibration");
}

TEST(FaultMatrix, C1_ACalibrationWhoseHashDoesNotFitIsNotArmed) {
  CalibratedBooth booth;
  auto& bytes = booth.disk_.files[kFile];
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  bytes[text.find("0.25")] = std::byte{'1'};
  EXPECT_EQ(Armed(booth, "calibration"),
            "read the calibration CAL.json: its hash does not fit its content: it was edited or damaged: take the last "
            "good calibration file, or calibrate the ring again");
}

TEST(FaultMatrix, C2_ACalibrationFileThatIsEditedDuringAScanChangesNothingOfIt) {
  CalibratedBooth booth;
  FaultRig rig(booth.Options());
  const CalibrationFile before = booth.file_;
  bool edited = false;
  const auto ended = [&] {
    if (!edited && rig.levels("scan.mcap") >= 10) {
      booth.file_.calibration.sensors[7].range_offset_mm = 5.0;
      booth.Write();
      edited = true;
    }
    return rig.status().scan && rig.state() == ScanState::kIdle;
  };
  ASSERT_TRUE(rig.Operate(ended)) << rig.Told();
  ASSERT_TRUE(edited);
  const Recording recording = RecordedScan(rig);
  EXPECT_EQ(recording.scan.levels.size(), FaultRig::WholeScan());
  const RingCalibration& carried = recording.scan.header.calibration;
  EXPECT_EQ(carried.certificate, before.calibration.certificate);
  EXPECT_NE(carried.certificate, booth.file_.calibration.certificate);
  EXPECT_EQ(carried.sensors, before.calibration.sensors);
  // The next scan, asked for with the old one still, is not armed.
  ASSERT_TRUE(rig.Arm());
  rig.Pass(milliseconds(2000));
  EXPECT_THAT(RefusalOf(rig, "calibration"), HasSubstr("was changed since the scan was asked for"));
  EXPECT_EQ(JudgeRest(rig), "");
}

/// A column that stands a hand's breadth off the axis, as high as the short plan needs.
CalibrationTarget Column() {
  CalibrationTarget target;
  target.radius_mm = 150.0;
  target.expanded_u_mm = 0.02;
  target.height_mm = 1900.0;
  return target;
}
FaultRigOptions WithColumn(FaultRigOptions options, double true_radius_mm) {
  sim::TargetTruth truth;
  truth.radius_mm = true_radius_mm;
  sim::TargetPlacement at;
  at.x_mm = 60.0;
  at.y_mm = -80.0;
  options.booth.subject = std::make_unique<sim::TargetSubject>(Column(), truth, at);
  options.booth.beam.noise_sigma_mm = 0.5;
  return options;
}

/// What the daily check says of a scan of that column.
ReferenceRecord Checked(FaultRigOptions options) {
  FaultRig rig(std::move(options));
  EXPECT_TRUE(rig.Operate([&] { return rig.status().scan && rig.state() == ScanState::kIdle; })) << rig.Told();
  const auto record = CheckReference(RecordedScan(rig).scan, Column());
  EXPECT_TRUE(record) << record.error().Text();
  return record ? *record : ReferenceRecord{};
}

TEST(FaultMatrix, S7_TwoExchangedChannelsAreNamedByTheDailyCheckAndKeepScansFromBeingArmed) {
  for (const auto& [sensor, other, named] :
       {std::tuple(48, 51, "channels 3 and 6"), std::tuple(47, 57, "channels 2 and 12")}) {
    CalibratedBooth booth;
    FaultRigOptions options = FaultRig::With("S7");
    options.plan.faults.front().args.Set(sim::FaultArg::kSensor, sensor);
    options.plan.faults.front().args.Set(sim::FaultArg::kOther, other);
    const ReferenceRecord record = Checked(WithColumn(booth.Options(std::move(options)), 150.0));
    EXPECT_FALSE(record.passed);
    EXPECT_THAT(record.findings, Contains(AllOf(HasSubstr("1004"), HasSubstr(named))));
    ASSERT_FALSE(record.findings.empty());
    booth.WriteCheck(record);
    EXPECT_THAT(Armed(booth, "reference"), HasSubstr(record.findings.front()));
    ReportNote(record.findings.back());
  }
}

TEST(FaultMatrix, C3_AReferenceCheckOutOfToleranceIsNotArmed) {
  CalibratedBooth booth;
  const ReferenceRecord good = Checked(WithColumn(booth.Options(), 150.0));
  EXPECT_TRUE(good.passed) << (good.findings.empty() ? "" : good.findings.front());
  booth.WriteCheck(good);
  EXPECT_EQ(Armed(booth, "reference"), "");
  const ReferenceRecord bad = Checked(WithColumn(booth.Options(), 150.5));
  EXPECT_FALSE(bad.passed);
  ASSERT_FALSE(bad.findings.empty());
  booth.WriteCheck(bad);
  EXPECT_THAT(Armed(booth, "reference"), HasSubstr(bad.findings.front()));
  ReportNote(bad.findings.front());
}

TEST(FaultMatrix, C3_AReferenceCheckThatIsMissingOrTooOldIsNotArmed) {
  CalibratedBooth booth;
  booth.config_.calibration.reference_check = kCheck;
  EXPECT_THAT(Armed(booth, "reference"), HasSubstr("there is no reference check of the ring"));
  ReferenceRecord record;
  record.passed = true;
  record.calibration = booth.file_.calibration.certificate;
  record.wall_start_ns = CalibratedBooth::kNow - kDayNs - 1;
  record.sensors.resize(180);
  booth.WriteCheck(record);
  EXPECT_THAT(Armed(booth, "reference"), HasSubstr("it is 24 hours old"));
}

}  // namespace
}  // namespace annulus::faults
