#include "station/calibration_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <span>

#include "acquisition/reference_record.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using testing::HasSubstr;
using Uncalibrated = CalibrationConfig::Uncalibrated;

constexpr char kPath[] = "CAL.json";
constexpr std::int64_t kDayNs = 86'400'000'000'000;

/// A booth whose ring of twelve boards was calibrated at the start of the simulated wall clock.
class CalibrationGateTest : public testing::Test {
 protected:
  void SetUp() override {
    for (std::uint16_t board = 0; board < 12; ++board) {
      machine_.boards.push_back({1001U + board, static_cast<std::uint16_t>(15 * board), 15, 2, "1.2.0"});
    }
    file_.calibration = RingCalibration::Ideal(600.0);
    file_.calibration.sensors[7].range_offset_mm = 0.7;
    file_.calibration.ring_serial = RingSerialOf(machine_.boards);
    file_.boards = machine_.boards;
    file_.wall_ns = clock_.WallNow().count();
    file_.valid_until_ns = file_.wall_ns + 90 * kDayNs;
    file_.passed = true;
    config_.calibration.file = kPath;
    Write();
  }
  void Write() {
    const Status written = WriteCalibrationFile(storage_, kPath, file_);
    ASSERT_TRUE(written) << written.error().Text();
  }
  /// What the gate says of a scan that was asked for with the calibration in force.
  Status Ask(const std::string& profile = "body") {
    const auto calibration = CalibrationInForce(config_, profile, storage_);
    if (!calibration) return Fail(calibration);
    return Ask(profile, *calibration);
  }
  Status Ask(const std::string& profile, const RingCalibration& calibration) {
    CalibrationGate gate(config_, storage_);
    gate.UseClock(clock_);
    ArmRequest request;
    request.plan.profile = profile;
    request.plan.of_target = profile == "check" || IsTargetProfile(profile);
    request.header.profile = profile;
    request.header.calibration = calibration;
    const GateAnswer answer = gate.Ask(request, machine_);
    EXPECT_TRUE(answer.customer && answer.consent && answer.store) << "those are for others";
    reference_ = answer.reference;
    return answer.calibration;
  }

  Config config_ = SimulatedConfig();
  Status reference_;  ///< What it said of the reference check.
  CalibrationFile file_;
  RecordedMachine machine_;
  test::TestStorage storage_;
  ManualClock clock_;
};

TEST_F(CalibrationGateTest, LetsTheCalibratedRingPassWithItsCalibration) {
  const auto calibration = CalibrationInForce(config_, "body", storage_);
  ASSERT_TRUE(calibration) << calibration.error().Text();
  EXPECT_EQ(calibration->sensors[7].range_offset_mm, 0.7);
  EXPECT_EQ(calibration->certificate, file_.calibration.certificate);
  const Status passed = Ask();
  EXPECT_TRUE(passed) << passed.error().Text();
}

TEST_F(CalibrationGateTest, NamesAFileThatIsMissing) {
  storage_.files.clear();
  EXPECT_THAT(CalibrationInForce(config_, "body", storage_).error().Text(), HasSubstr(kPath));
  EXPECT_THAT(Ask("body", file_.calibration).error().Text(), HasSubstr(kPath));
}

TEST_F(CalibrationGateTest, RefusesADamagedFile) {
  storage_.files[kPath][storage_.files[kPath].size() / 2] ^= std::byte{1};
  EXPECT_FALSE(CalibrationInForce(config_, "body", storage_));
  EXPECT_FALSE(Ask("body", file_.calibration));
}

TEST_F(CalibrationGateTest, RefusesOneThatHasExpired) {
  EXPECT_TRUE(Ask());
  clock_.SleepUntil(std::chrono::hours(24 * 90 + 1));
  const Status late = Ask();
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().seen, "it was valid until 2000-03-31T00:00:00Z");
}

TEST_F(CalibrationGateTest, RefusesTheCalibrationOfAnotherRingAndNamesTheBoard) {
  machine_.boards[3].serial = 2004;
  const Status other = Ask();
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().seen, "board 2004 (sensors 45 to 59) is not the one that was calibrated there (1004)");
}

TEST_F(CalibrationGateTest, RefusesTheCalibrationOfARingWithOtherSensors) {
  file_.calibration = RingCalibration::Ideal(600.0, 120);
  Write();
  const auto calibration = CalibrationInForce(config_, "body", storage_);
  ASSERT_FALSE(calibration);
  EXPECT_EQ(calibration.error().seen, "it is of 120 sensors, the ring has 180");
}

TEST_F(CalibrationGateTest, NoticesThatTheFileWasChangedSinceTheScanWasAskedFor) {
  const auto before = CalibrationInForce(config_, "body", storage_);
  ASSERT_TRUE(before);
  file_.calibration.sensors[7].range_offset_mm = 0.8;
  Write();
  const Status changed = Ask("body", *before);
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().seen, "the calibration file was changed since the scan was asked for");
  EXPECT_TRUE(Ask());
}

TEST_F(CalibrationGateTest, AnUncalibratedRingIsRefusedOrMarkedAsTheBoothWantsIt) {
  config_.calibration.file.clear();
  EXPECT_TRUE(Ask()) << "a simulated booth marks";
  config_.ring.bus = RingBus::kUsb;
  const Status real = Ask();
  ASSERT_FALSE(real);
  EXPECT_EQ(real.error().seen,
            "the ring is not calibrated: none was accepted at the console, and [calibration] file names none");
  EXPECT_THAT(real.error().advice, HasSubstr("annulus calibrate"));
  config_.calibration.uncalibrated = Uncalibrated::kMark;
  EXPECT_TRUE(Ask());
  EXPECT_TRUE(CalibrationInForce(config_, "body", storage_)->certificate.empty());
  config_.ring.bus = RingBus::kSimulated;
  config_.calibration.uncalibrated = Uncalibrated::kRefuse;
  EXPECT_FALSE(Ask());
}

TEST_F(CalibrationGateTest, WithoutANamedFileTheOneAcceptedAtTheConsoleIsInForceOnceThereIsOne) {
  config_.calibration.file.clear();
  config_.calibration.uncalibrated = Uncalibrated::kRefuse;
  config_.store.recordings = "/booth";
  storage_.files.clear();
  EXPECT_FALSE(Ask()) << "none was accepted yet";
  EXPECT_TRUE(CalibrationInForce(config_, "body", storage_)->certificate.empty());
  ASSERT_TRUE(WriteCalibrationFile(storage_, "/booth/calibration.json", file_));
  const auto calibration = CalibrationInForce(config_, "body", storage_);
  ASSERT_TRUE(calibration) << calibration.error().Text();
  EXPECT_EQ(calibration->certificate, file_.calibration.certificate);
  EXPECT_TRUE(Ask());
  storage_.files["/booth/calibration.json"].resize(100);
  EXPECT_FALSE(CalibrationInForce(config_, "body", storage_)) << "a damaged one is not passed over";
  EXPECT_FALSE(Ask("body", file_.calibration));
}

TEST(CalibrationPath, IsTheNamedFileOrBesideTheRecordings) {
  Config config;
  EXPECT_EQ(CalibrationPath(config), "");
  config.store.folder = "/store";
  EXPECT_EQ(CalibrationPath(config), "/store/recordings/calibration.json");
  config.store.recordings = "/booth";
  EXPECT_EQ(CalibrationPath(config), "/booth/calibration.json");
  config.calibration.file = "/etc/CAL.json";
  EXPECT_EQ(CalibrationPath(config), "/etc/CAL.json");
}

TEST_F(CalibrationGateTest, TargetsAreScannedByTheIdealRingWhateverTheFileIs) {
  storage_.files.clear();
  config_.ring.bus = RingBus::kUsb;
  for (const char* profile : {"target", "target_fine", "target_short"}) {
    EXPECT_TRUE(IsTargetProfile(profile));
    const auto calibration = CalibrationInForce(config_, profile, storage_);
    ASSERT_TRUE(calibration);
    EXPECT_EQ(calibration->sensors, RingCalibration::Ideal(600.0).sensors);
    EXPECT_TRUE(Ask(profile)) << profile;
  }
  EXPECT_FALSE(IsTargetProfile("body"));
  EXPECT_FALSE(Ask("body"));
}

/// A reference check of this ring and calibration that passed an hour ago.
class ReferenceGateTest : public CalibrationGateTest {
 protected:
  void SetUp() override {
    CalibrationGateTest::SetUp();
    config_.calibration.reference_check = "check.json";
    record_.ring_serial = file_.calibration.ring_serial;
    record_.calibration = file_.calibration.certificate;
    record_.wall_start_ns = clock_.WallNow().count();
    record_.passed = true;
    record_.sensors.resize(180);
    clock_.SleepUntil(std::chrono::hours(1));
  }
  Status AskReference(const std::string& profile = "body") {
    const std::string text = JsonFromCheck(record_).dump();
    const auto bytes = std::as_bytes(std::span(text));
    storage_.files["check.json"] = {bytes.begin(), bytes.end()};
    const Status calibration = Ask(profile);
    EXPECT_TRUE(calibration) << calibration.error().Text();
    return reference_;
  }
  ReferenceRecord record_;
};

TEST_F(ReferenceGateTest, LetsAGoodAndFreshCheckPass) {
  const Status passed = AskReference();
  EXPECT_TRUE(passed) << passed.error().Text();
}

TEST_F(ReferenceGateTest, RefusesACheckThatIsMissingOrDamaged) {
  ASSERT_TRUE(Ask());
  ASSERT_FALSE(reference_);
  EXPECT_THAT(reference_.error().Text(), HasSubstr("there is no reference check of the ring"));
  EXPECT_THAT(reference_.error().advice, HasSubstr("annulus check"));
  storage_.files["check.json"] = {std::byte{'{'}};
  ASSERT_TRUE(Ask());
  EXPECT_THAT(reference_.error().Text(), HasSubstr("check.json"));
}

TEST_F(ReferenceGateTest, RefusesACheckThatFailedAndSaysWhy) {
  record_.passed = false;
  record_.findings = {"all sensors together read 0.43 mm too long"};
  record_.advice = {"calibrate the ring"};
  const Status failed = AskReference();
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().seen, "all sensors together read 0.43 mm too long");
  EXPECT_EQ(failed.error().advice, "calibrate the ring");
}

TEST_F(ReferenceGateTest, RefusesACheckThatIsTooOldOrOfAnotherCalibration) {
  config_.calibration.reference_hours = 12.0;
  clock_.SleepUntil(std::chrono::hours(12));
  EXPECT_TRUE(AskReference());
  clock_.SleepUntil(std::chrono::hours(13));
  EXPECT_THAT(AskReference().error().seen, HasSubstr("hours old"));
  config_.calibration.reference_hours = 24.0;
  record_.calibration = "sha256:before";
  EXPECT_THAT(AskReference().error().seen, HasSubstr("calibrated since"));
  record_.calibration = file_.calibration.certificate;
  record_.ring_serial = "ring-other";
  EXPECT_THAT(AskReference().error().seen, HasSubstr("ring-other"));
}

TEST_F(ReferenceGateTest, ACheckIsScannedWithoutACheck) {
  for (const char* profile : {"check", "target"}) {
    ASSERT_TRUE(Ask(profile));
    EXPECT_TRUE(reference_) << profile;
  }
  EXPECT_EQ(CalibrationInForce(config_, "check", storage_)->certificate, file_.calibration.certificate)
      << "it is the calibration that is checked";
}

}  // namespace
}  // namespace annulus
