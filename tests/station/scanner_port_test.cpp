#include "station/scanner_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "station/booth_session.h"
#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using testing::HasSubstr;

TEST(RecordingPath, LeadsNowhereButBelowTheFolder) {
  EXPECT_EQ(*RecordingPath("/scans", "a.mcap"), "/scans/a.mcap");
  EXPECT_EQ(*RecordingPath("/scans", "2026/a b-1.mcap"), "/scans/2026/a b-1.mcap");
  for (const char* name : {"", ".", "..", "a", "a.txt", "/etc/a.mcap", "../a.mcap", "a/../../b.mcap", ".a.mcap",
                           "a/.b.mcap", ".mcap", "a/", "./a.mcap", "a.mcap/", "a.mcap/.."}) {
    EXPECT_FALSE(RecordingPath("/scans", name)) << name;
  }
}

/// The simulated booth in virtual time, without anybody at it.
class ScannerPortTest : public testing::Test {
 protected:
  ScannerPortTest() {
    config_.profiles["short"].z_top_mm = 1700.0;
    config_.profiles["short"].z_bottom_mm = 1650.0;
    config_.profiles["short"].pitch_mm = 5.0;
    config_.profiles["short"].speed_mm_s = 100.0;
    BoothSessionOptions options;
    options.sim_operator = SimOperator::kNobody;
    auto session = BoothSession::Open(config_, gate_, storage_, options);
    if (!session) throw std::runtime_error(session.error().Text());
    session_ = std::move(*session);
    BoothDescription description;
    description.simulated = true;
    port_ = std::make_unique<ScannerPort>(
        session_->scanner(), description,
        ScannerPortOptions{
            config_, storage_, folder_ / "scans", {{WarningCode::kMemoryUnlocked, "memory may be swapped", {}}}});
  }

  void RunTo(ScanState state) {
    ASSERT_TRUE(
        session_->RunUntil([&](const ScannerStatus& status) { return status.state == state && status.job.empty(); },
                           std::chrono::seconds(60)))
        << ScanStateText(port_->status().state);
  }
  void Pass(std::chrono::nanoseconds time) {
    session_->RunUntil([](const ScannerStatus&) { return false; }, time);
  }
  sim::SafetyChain& chain() { return session_->ground().booth()->safety(); }
  void PressReset() { chain().PressResetAt(session_->clock().Now()); }
  void PressStart() {
    chain().Set(InterlockInput::kStartKey, true);
    chain().SetAt(session_->clock().Now() + std::chrono::milliseconds(150), InterlockInput::kStartKey, false);
  }
  /// From power-up to homed.
  void MakeReady() {
    Pass(std::chrono::milliseconds(200));
    PressReset();
    RunTo(ScanState::kIdle);
    ASSERT_TRUE(port_->Home());
    RunTo(ScanState::kIdle);
    ASSERT_TRUE(port_->status().homed);
  }
  static ArmOrder Short(const std::string& out) { return {"short", {}, false, out, "s-1", "c-1"}; }

  test::FreshFolder folder_;
  Config config_ = SimulatedConfig();
  PosixStorage storage_;
  PermissiveGate gate_;
  std::unique_ptr<BoothSession> session_;
  std::unique_ptr<ScannerPort> port_;
};

TEST_F(ScannerPortTest, StartsOnlyWhatSomebodyAtTheBoothAgreesTo) {
  MakeReady();
  PressStart();  // before it is armed it counts for nothing
  Pass(std::chrono::milliseconds(300));
  ASSERT_TRUE(port_->Arm(Short("day/a.mcap")));
  RunTo(ScanState::kArmed);
  const std::uint64_t version = port_->status().version;
  const Status from_afar = port_->Start(version);
  ASSERT_FALSE(from_afar);
  EXPECT_THAT(from_afar.error().Text(), HasSubstr("start key"));
  PressStart();
  Pass(std::chrono::milliseconds(300));
  const Status stale = port_->Start(version - 1);
  ASSERT_FALSE(stale);
  EXPECT_THAT(stale.error().Text(), HasSubstr("has changed"));
  ASSERT_TRUE(port_->Start(version));
  RunTo(ScanState::kIdle);
  const ScannerStatus status = port_->status();
  ASSERT_TRUE(status.scan);
  EXPECT_TRUE(status.scan->complete) << (status.scan->status ? "" : status.scan->status.error().Text());
  EXPECT_EQ(status.scan->recording, folder_ / "scans/day/a.mcap");
  const auto recording = ReadWholeRecording(storage_, folder_ / "scans/day/a.mcap");
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->scan.header.subject_id, "s-1");
  EXPECT_EQ(recording->scan.header.consent_reference, "c-1");
  EXPECT_EQ(recording->scan.levels.size(), 10U) << "50 mm at 5 mm; none at the bottom itself";
  const Status again = port_->Arm(Short("day/a.mcap"));
  ASSERT_FALSE(again) << "a recording is never written over";
  EXPECT_THAT(again.error().Text(), HasSubstr("already"));
  // The press of before starts nothing either.
  ASSERT_TRUE(port_->Arm(Short("day/b.mcap")));
  RunTo(ScanState::kArmed);
  EXPECT_FALSE(port_->Start(port_->status().version));
}

TEST_F(ScannerPortTest, APressOfTheStartKeyCountsOnlyWhileItIsArmedAndNotForLong) {
  MakeReady();
  PressStart();  // when the checks have begun
  ASSERT_TRUE(port_->Arm(Short("a.mcap")));
  RunTo(ScanState::kArmed);
  EXPECT_FALSE(port_->Start(port_->status().version)) << "pressed before it was armed";
  PressStart();
  Pass(std::chrono::seconds(11));
  ASSERT_EQ(port_->status().state, ScanState::kArmed);
  EXPECT_FALSE(port_->Start(port_->status().version)) << "whoever pressed it has long gone away";
  // Armed anew: the press was for the former plan.
  PressStart();
  Pass(std::chrono::milliseconds(300));
  ASSERT_TRUE(port_->Arm(Short("b.mcap")));
  RunTo(ScanState::kArmed);
  EXPECT_FALSE(port_->Start(port_->status().version));
  PressStart();
  Pass(std::chrono::milliseconds(300));
  EXPECT_TRUE(port_->Start(port_->status().version));
}

TEST_F(ScannerPortTest, RefusesWhatCannotBePlannedBeforeTheBoothIsAsked) {
  MakeReady();
  ArmOrder order = Short("a.mcap");
  order.profile = "head";
  const Status no_height = port_->Arm(order);
  ASSERT_FALSE(no_height);
  EXPECT_THAT(no_height.error().Text(), HasSubstr("enter the height"));
  order.profile = "nonesuch";
  EXPECT_FALSE(port_->Arm(order));
  EXPECT_FALSE(port_->Arm(Short("../a.mcap")));
  EXPECT_EQ(port_->status().state, ScanState::kIdle);
  EXPECT_TRUE(port_->status().job.empty());
  EXPECT_THAT(port_->status().warnings, testing::Contains(testing::Field(&ScanWarning::text, "memory may be swapped")));
}

TEST_F(ScannerPortTest, WantsSubjectAndConsentOnARealBooth) {
  BoothDescription real;
  real.simulated = false;
  ScannerPort port(session_->scanner(), real, {config_, storage_, folder_ / "scans", {}});
  ArmOrder order = Short("a.mcap");
  order.consent.clear();
  const Status refused = port.Arm(order);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("consent"));
}

}  // namespace
}  // namespace annulus
