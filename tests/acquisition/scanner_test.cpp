#include "acquisition/scanner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/acquisition/scanner_rig.h"

namespace annulus {
namespace {

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

}  // namespace
}  // namespace annulus
