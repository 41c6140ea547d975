#include "tests/firmware_iface/usb_ring_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace annulus::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(UsbRangeRingFaults, B1_ABoardGoneInMidScanIsNamedWithinTwoLevelPeriods) {
  std::mt19937_64 random(1);
  for (std::size_t board = 0; board < Booth::kBoards; ++board) {
    OpenAndStart();
    const auto before = static_cast<int>(1 + random() % 40);
    ASSERT_TRUE(Read(before));
    const nanoseconds unplugged = Now() + nanoseconds(random() % 20'000'000);
    host_.UnplugAt(board, unplugged);
    levels_ = 0;
    const auto level = Read(10);
    ASSERT_FALSE(level);
    EXPECT_LE(Now() - unplugged, 2 * kPeriod);
    EXPECT_LE(levels_, 2U);
    EXPECT_THAT(level.error().Text(), HasSubstr("ring board " + std::to_string(1001 + board)));
    EXPECT_THAT(level.error().Text(), HasSubstr("unplugged"));
    EXPECT_EQ(ring_->state(), RangeRing::State::kFailed);
    ASSERT_TRUE(ring_->Stop());
    EXPECT_EQ(false_samples_, 0U);
    EXPECT_EQ(missing_, 0U);
    host_.PlugAt(board, Now());
    ring_.reset();
  }
}

TEST_F(UsbRangeRingFaults, B2_ABoardBackAfter300MillisecondsIsOpenedAgainAndNothingResumes) {
  OpenAndStart();
  ASSERT_TRUE(Read(10));
  host_.UnplugAt(4, Now());
  host_.PlugAt(4, Now() + milliseconds(300), milliseconds(500));
  ASSERT_FALSE(Read(10));
  const nanoseconds stopping = Now();
  ASSERT_TRUE(ring_->Stop());
  const Status reopened = ring_->Reopen(stopping + seconds(3));
  ASSERT_TRUE(reopened) << reopened.error().Text();
  EXPECT_LE(Now() - stopping, seconds(3));
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  booth_.clock().SleepUntil(Now() + seconds(1));
  for (std::size_t i = 0; i < Booth::kBoards; ++i) EXPECT_EQ(booth_.board(i).in_flight(), 0U) << "nothing was started";
  EXPECT_FALSE(Next());
  ASSERT_TRUE(ring_->Start(kRate));
  ASSERT_TRUE(Read(50));
  EXPECT_EQ(missing_ + false_samples_, 0U);
  const auto left = host_.WaitHotplug(Now());
  const auto arrived = host_.WaitHotplug(Now());
  ASSERT_TRUE(left && arrived);
  EXPECT_EQ(left->kind, UsbHotplug::Kind::kLeft);
  EXPECT_EQ(arrived->kind, UsbHotplug::Kind::kArrived);
  EXPECT_EQ(arrived->identity.serial, "RB1005");
  EXPECT_EQ(arrived->host_time - left->host_time, milliseconds(300));
}

TEST_F(UsbRangeRingFaults, B3_TwelveBoardsGoneWithinTenMillisecondsAreOneCause) {
  for (const auto ending : {UsbFaultPlan::UnplugEnding::kNoDevice, UsbFaultPlan::UnplugEnding::kError,
                            UsbFaultPlan::UnplugEnding::kCompleted, UsbFaultPlan::UnplugEnding::kAny}) {
    for (UsbFaultPlan& plan : plans_) plan.unplug_ending = ending;
    OpenAndStart();
    ASSERT_TRUE(Read(10));
    const nanoseconds begin = Now() + milliseconds(3);
    std::mt19937_64 random(3);
    for (std::size_t board = 0; board < Booth::kBoards; ++board) {
      host_.UnplugAt(board, begin + nanoseconds(random() % 10'000'000));
    }
    const auto level = Read(10);
    ASSERT_FALSE(level);
    EXPECT_THAT(level.error().seen, HasSubstr("all 12 boards are unplugged at once"));
    EXPECT_THAT(level.error().Text(), Not(HasSubstr("ring board 10"))) << "one cause, not twelve";
    EXPECT_LE(Now() - begin, 2 * kPeriod + milliseconds(20));
    static_cast<void>(ring_->Stop());
    for (std::size_t board = 0; board < Booth::kBoards; ++board) host_.PlugAt(board, Now(), seconds(1));
    const Status reopened = ring_->Reopen(Now() + seconds(3));
    ASSERT_TRUE(reopened) << reopened.error().Text();
    ring_.reset();
  }
}

TEST_F(UsbRangeRingFaults, B3_TheBoardsOfOneHubAreNamedTogether) {
  OpenAndStart();
  ASSERT_TRUE(Read(10));
  for (const std::size_t board : {2U, 3U, 7U}) host_.UnplugAt(board, Now() + milliseconds(5) + nanoseconds(board));
  const auto level = Read(10);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().seen, HasSubstr("3 boards are unplugged at once"));
  for (const char* serial : {"1003", "1004", "1008"}) EXPECT_THAT(level.error().seen, HasSubstr(serial));
  EXPECT_THAT(level.error().seen, Not(HasSubstr("1005")));
}

TEST_F(UsbRangeRingFaults, B4_ShortLongEmptyAndDamagedPacketsAreCountedExactlyAndNeverBelieved) {
  for (UsbFaultPlan& plan : plans_) {
    plan.short_share = 0.004;
    plan.zero_share = 0.004;
    plan.long_share = 0.02;
    plan.damage_share = 0.004;
  }
  OpenAndStart();
  const auto level = Read(1500);
  ASSERT_TRUE(level) << level.error().Text();
  // Then all is well for a while, so that whatever was spoiled has been missed.
  for (FaultyUsbPort* port : faulty_) port->SetPlan({});
  ASSERT_TRUE(Read(5));
  const UsbFaultLog log = Sum();
  for (const std::uint64_t count : {log.shortened, log.emptied, log.damaged}) EXPECT_GT(count, 40U);
  EXPECT_GT(log.lengthened, 200U);
  EXPECT_EQ(ring_->counters().lost_frames, log.shortened + log.emptied + log.damaged);
  EXPECT_EQ(ring_->counters().rejected_bytes, log.added_bytes + log.kept_bytes + log.damaged * kLevelFrameBytes);
  EXPECT_EQ(missing_, ring_->counters().lost_frames * 15);
  EXPECT_EQ(false_samples_, 0U);
}

TEST_F(UsbRangeRingFaults, B4_ABoardThatOnlySendsRubbishStopsTheScan) {
  plans_[7].damage_share = 0.5;
  OpenAndStart();
  const auto level = Read(200);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1008"));
  EXPECT_THAT(level.error().Text(), HasSubstr("loses frames repeatedly"));
  EXPECT_EQ(false_samples_, 0U);
  EXPECT_EQ(ring_->state(), RangeRing::State::kFailed);
}

TEST_F(UsbRangeRingFaults, B5_AStallIsClearedOnceAndTheScanGoesOn) {
  OpenAndStart();
  ASSERT_TRUE(Read(20));
  ring_.reset();
  // The same again with one halt, at about the twentieth frame of one board.
  plans_[3].stall_share = 0.02;
  plans_[3].seed = 8;
  OpenAndStart();
  while (logs_[3].stalls == 0) {
    const auto level = Read(1);
    ASSERT_TRUE(level) << level.error().Text();
  }
  const nanoseconds halted = Now();
  ASSERT_TRUE(Read(1));
  EXPECT_EQ(logs_[3].halts_cleared, 1U);
  EXPECT_LE(Now() - halted, milliseconds(500));
  EXPECT_EQ(false_samples_, 0U);
}

TEST_F(UsbRangeRingFaults, B5_AnEndpointThatStaysHaltedIsAFaultAndIsOpenedAgain) {
  plans_[3].stall_share = 1.0;
  plans_[3].stall_stays = true;
  OpenAndStart();
  const nanoseconds begin = Now();
  const auto level = Read(30);
  ASSERT_FALSE(level);
  EXPECT_LE(Now() - begin, milliseconds(500));
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1004"));
  EXPECT_THAT(level.error().Text(), HasSubstr("opened again"));
  EXPECT_EQ(logs_[3].halts_cleared, 1U) << "cleared once, not for ever";
  ASSERT_TRUE(ring_->Stop());
  plans_[3] = {};
  const std::uint64_t attempts = host_.open_attempts();
  ASSERT_TRUE(ring_->Reopen(Now() + seconds(3)));
  EXPECT_EQ(host_.open_attempts(), attempts + 1) << "only the halted board is opened anew";
  ASSERT_TRUE(ring_->Start(kRate));
  ASSERT_TRUE(Read(50));
}

TEST_F(UsbRangeRingFaults, B6_DataOfTransfersThatTimedOutIsUsedAsFarAsItIsWhole) {
  for (UsbFaultPlan& plan : plans_) plan.timeout_share = 0.2;
  OpenAndStart();
  ASSERT_TRUE(Read(500));
  EXPECT_GT(Sum().timed_out, 1000U);
  EXPECT_EQ(ring_->counters().lost_frames, 0U);
  EXPECT_EQ(missing_ + false_samples_, 0U);
}

}  // namespace
}  // namespace annulus::test
