#include "tests/firmware_iface/range_ring_contract.h"

#include <gmock/gmock.h>

#include <cmath>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus::contract {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

namespace {

/// Crystals are within this of each other, ppm; the simulated ones draw up to 20, a virtual machine's clock is worse.
constexpr double kClockRate = 500e-6;

}  // namespace

void RangeRingContract::SetUp() {
  fixture_ = GetParam().make();
  ASSERT_NE(fixture_, nullptr);
  expected_ = fixture_->boards();
  auto ring = fixture_->Make();
  ASSERT_TRUE(ring) << ring.error().Text();
  ring_ = std::move(*ring);
}

nanoseconds RangeRingContract::Patient(nanoseconds time) const {
  return nanoseconds(std::llround(static_cast<double>(time.count()) * fixture_->patience()));
}

nanoseconds RangeRingContract::In(nanoseconds time) const { return fixture_->clock().Now() + Patient(time); }

Result<RingLevel> RangeRingContract::Next() { return ring_->NextLevel(In(milliseconds(500))); }

Result<RingLevel> RangeRingContract::ReadUntilFailure() {
  Result<RingLevel> level = Next();
  for (double levels = 2.0 * fixture_->level_rate().value(); level && levels > 0.0; levels -= 1.0) level = Next();
  return level;
}

void RangeRingContract::ExpectRanges(const RingLevel& level) const {
  const std::size_t sensors = kSensorsPerBoard * expected_.size();
  ASSERT_EQ(level.range_mm.size(), sensors);
  ASSERT_EQ(level.quality.size(), sensors);
  for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
    const double expected = fixture_->expected_range_mm(sensor);
    if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(level.range_mm[sensor])) << "sensor " << sensor;
      EXPECT_EQ(level.quality[sensor], 0) << "sensor " << sensor;
    } else {
      EXPECT_NEAR(level.range_mm[sensor], expected, fixture_->tolerance_mm()) << "sensor " << sensor;
    }
  }
}

void RangeRingContract::ExpectLevels(std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t sequence = first; sequence < first + count; ++sequence) {
    const auto level = Next();
    ASSERT_TRUE(level) << level.error().Text();
    ASSERT_EQ(level->sequence, sequence);
    ASSERT_EQ(level->boards.size(), expected_.size());
    for (const BoardStamp& stamp : level->boards) {
      EXPECT_TRUE(stamp.present);
      EXPECT_LE(stamp.host_arrival, fixture_->clock().Now());
    }
    ExpectRanges(*level);
  }
}

void RangeRingContract::ExpectNamed(const std::string& text, std::size_t board) const {
  EXPECT_THAT(text, HasSubstr(std::to_string(expected_[board].serial)));
}

void RangeRingContract::ExpectUnusable(const Error& refused) {
  const Status started = ring_->Start(fixture_->level_rate());
  ASSERT_FALSE(started) << "who is where is not known";
  EXPECT_EQ(started.error().Text(), refused.Text());
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  EXPECT_FALSE(Next());
  for (std::size_t board = 0; board < expected_.size(); ++board) EXPECT_FALSE(ring_->ReadClock(board));
}

void RangeRingContract::ExpectClock(std::size_t board) {
  std::optional<ClockExchange> last;
  for (int i = 0; i < 5; ++i) {
    const nanoseconds asked = fixture_->clock().Now();
    const auto now = ring_->ReadClock(board);
    ASSERT_TRUE(now) << now.error().Text();
    EXPECT_GE(now->host_before, asked);
    EXPECT_GE(now->host_after, now->host_before);
    EXPECT_LE(now->host_after, fixture_->clock().Now());
    EXPECT_LT(now->host_after - now->host_before, Patient(milliseconds(100)));
    EXPECT_GE(now->device_time, fixture_->DeviceTime(board, now->host_before).value_or(now->device_time));
    EXPECT_LE(now->device_time, fixture_->DeviceTime(board, now->host_after).value_or(now->device_time));
    if (last) {
      // Between two answers the board's clock moved by what passed between them, on either clock.
      const double moved = static_cast<double>((now->device_time - last->device_time).count());
      const double least = static_cast<double>((now->host_before - last->host_after).count());
      const double most = static_cast<double>((now->host_after - last->host_before).count());
      EXPECT_GT(moved, least * (1.0 - kClockRate) - 2.0);
      EXPECT_LT(moved, most * (1.0 + kClockRate) + 2.0);
    }
    last = *now;
  }
}

TEST_P(RangeRingContract, KnowsItsBoardsAndTheirSensors) {
  ASSERT_EQ(ring_->boards().size(), expected_.size());
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    EXPECT_EQ(ring_->boards()[i].serial, expected_[i].serial);
    EXPECT_EQ(ring_->boards()[i].first_sensor, expected_[i].first_sensor);
    EXPECT_EQ(ring_->boards()[i].sensor_count, kSensorsPerBoard);
    EXPECT_FALSE(ring_->boards()[i].firmware_version.empty());
    EXPECT_FALSE(ring_->boards()[i].port_path.empty());
  }
  EXPECT_EQ(ring_->limits().sensor_count, kSensorsPerBoard * expected_.size());
  EXPECT_LE(ring_->limits().min_level_rate, fixture_->level_rate());
  EXPECT_GE(ring_->limits().max_level_rate, fixture_->level_rate());
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
}

TEST_P(RangeRingContract, ReadsLevelsInOrderFromZeroWithEverySensor) {
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 30);
  EXPECT_EQ(ring_->counters().levels, 30U);
  EXPECT_EQ(ring_->counters().lost_frames, 0U);
  EXPECT_EQ(ring_->counters().duplicate_frames, 0U);
  EXPECT_EQ(ring_->counters().rejected_frames, 0U);
  const Status stopped = ring_->Stop();
  EXPECT_TRUE(stopped) << stopped.error().Text();
  EXPECT_EQ(ring_->counters().levels, 30U) << "a stopped ring still tells what it counted";
}

TEST_P(RangeRingContract, FiresAtTheOrderedRate) {
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  const auto first = Next();
  ASSERT_TRUE(first) << first.error().Text();
  ExpectLevels(1, 19);
  const auto last = Next();
  ASSERT_TRUE(last) << last.error().Text();
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    const double seconds_passed =
        static_cast<double>((last->boards[i].device_time - first->boards[i].device_time).count()) * 1e-9;
    // 1 ms: all sensors of a level fire within it. Both clocks of an emulated machine may be rough.
    const double expected = 20.0 / fixture_->level_rate().value();
    EXPECT_NEAR(seconds_passed, expected, fixture_->patience() * (1e-3 + kClockRate * expected)) << "board " << i;
  }
}

TEST_P(RangeRingContract, CanBeStartedAndStoppedManyTimes) {
  for (int run = 0; run < 20; ++run) {
    const Status started = ring_->Start(fixture_->level_rate());
    ASSERT_TRUE(started) << started.error().Text();
    EXPECT_EQ(ring_->state(), RangeRing::State::kStreaming);
    ExpectLevels(0, 2);
    EXPECT_EQ(ring_->counters().levels, 2U);
    const Status stopped = ring_->Stop();
    ASSERT_TRUE(stopped) << stopped.error().Text();
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  }
}

TEST_P(RangeRingContract, GivesNoReadingOfAnEarlierRun) {
  for (int run = 0; run < 5; ++run) {
    const auto before = ring_->ReadClock(0);
    ASSERT_TRUE(before) << before.error().Text();
    ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
    const auto level = Next();
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_GT(level->boards[0].device_time, before->device_time);
    ASSERT_TRUE(ring_->Stop());
  }
}

TEST_P(RangeRingContract, SaysInWhichStateACallCameAndWhichItNeeds) {
  const auto level = Next();
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().seen, HasSubstr("idle"));
  EXPECT_THAT(level.error().seen, HasSubstr("streaming"));
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  const Status again = ring_->Start(fixture_->level_rate());
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().seen, HasSubstr("streaming"));
  EXPECT_THAT(again.error().seen, HasSubstr("idle"));
  const Status reopened = ring_->Reopen(In(seconds(1)));
  ASSERT_FALSE(reopened) << "a ring that streams is not opened again";
  ExpectLevels(0, 2);
  EXPECT_TRUE(ring_->Stop());
  EXPECT_TRUE(ring_->Stop()) << "stopping twice is harmless";
}

TEST_P(RangeRingContract, RefusesLevelRatesThatItsBoardsDoNotHave) {
  const RingLimits limits = ring_->limits();
  for (const double rate :
       {0.0, -1.0, limits.min_level_rate.value() / 2, limits.max_level_rate.value() * 2, std::nan(""), HUGE_VAL}) {
    EXPECT_FALSE(ring_->Start(Hertz(rate))) << rate;
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  }
}

TEST_P(RangeRingContract, HonoursTheDeadlineOfALevelAndStartsAgainAfterwards) {
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  const nanoseconds past = fixture_->clock().Now();
  const auto level = ring_->NextLevel(past);
  ASSERT_FALSE(level) << "the first SYNC is a period away";
  EXPECT_LT(fixture_->clock().Now(), past + Patient(milliseconds(100)));
  EXPECT_EQ(ring_->state(), RangeRing::State::kFailed);
  EXPECT_FALSE(Next()) << "a failed ring gives no level";
  EXPECT_FALSE(ring_->ReadClock(0));
  EXPECT_TRUE(ring_->Stop());
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 3);
}

TEST_P(RangeRingContract, ReadsEachBoardsClockBetweenQuestionAndAnswer) {
  for (std::size_t board = 0; board < expected_.size(); ++board) ExpectClock(board);
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 1);
  for (std::size_t board = 0; board < expected_.size(); ++board) ExpectClock(board);
  ExpectLevels(1, 2);
}

TEST_P(RangeRingContract, OpensAnIdleRingAgainWithoutHarm) {
  for (int i = 0; i < 3; ++i) {
    const Status reopened = ring_->Reopen(In(seconds(3)));
    ASSERT_TRUE(reopened) << reopened.error().Text();
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
    ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
    ExpectLevels(0, 2);
    ASSERT_TRUE(ring_->Stop());
  }
}

TEST_P(RangeRingContract, NamesTheBoardThatIsUnpluggedInMidScanAndStops) {
  if (!fixture_->CanUnplug()) GTEST_SKIP() << "nothing can be unplugged here";
  const std::size_t board = expected_.size() / 2;
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 5);
  fixture_->Unplug(board);
  const nanoseconds unplugged = fixture_->clock().Now();
  const auto level = ReadUntilFailure();
  ASSERT_FALSE(level);
  ExpectNamed(level.error().Text(), board);
  EXPECT_LT(fixture_->clock().Now() - unplugged, Patient(seconds(1)));
  EXPECT_EQ(ring_->state(), RangeRing::State::kFailed);
  const nanoseconds stopping = fixture_->clock().Now();
  static_cast<void>(ring_->Stop());
  EXPECT_LT(fixture_->clock().Now() - stopping, Patient(seconds(1)) + milliseconds(500));
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
  const Status started = ring_->Start(fixture_->level_rate());
  ASSERT_FALSE(started) << "a board is missing";
  ExpectNamed(started.error().Text(), board);
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
}

TEST_P(RangeRingContract, StreamsAgainAfterReplugAndReopenButNeverByItself) {
  if (!fixture_->CanUnplug()) GTEST_SKIP() << "nothing can be unplugged here";
  for (const std::size_t board : {std::size_t{0}, expected_.size() - 1}) {
    ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
    ExpectLevels(0, 3);
    fixture_->Unplug(board);
    ASSERT_FALSE(ReadUntilFailure());
    static_cast<void>(ring_->Stop());
    fixture_->Replug(board);
    const Status reopened = ring_->Reopen(In(seconds(3)));
    ASSERT_TRUE(reopened) << reopened.error().Text();
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
    EXPECT_FALSE(Next()) << "nothing starts by itself";
    ASSERT_EQ(ring_->boards().size(), expected_.size());
    EXPECT_EQ(ring_->boards()[board].serial, expected_[board].serial);
    ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
    ExpectLevels(0, 5);
    const Status stopped = ring_->Stop();
    EXPECT_TRUE(stopped) << stopped.error().Text();
  }
}

TEST_P(RangeRingContract, SaysByTheDeadlineWhichBoardIsNotBack) {
  if (!fixture_->CanUnplug()) GTEST_SKIP() << "nothing can be unplugged here";
  const std::size_t board = expected_.size() - 1;
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  fixture_->Unplug(board);
  ASSERT_FALSE(ReadUntilFailure());
  static_cast<void>(ring_->Stop());
  const nanoseconds deadline = In(milliseconds(500));
  const Status reopened = ring_->Reopen(deadline);
  ASSERT_FALSE(reopened);
  ExpectNamed(reopened.error().Text(), board);
  EXPECT_LT(fixture_->clock().Now(), deadline + Patient(milliseconds(500)));
  EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
}

TEST_P(RangeRingContract, StartsNotAfterARefusedReopenThoughTheBoardIsBackUntilItIsOpenedAgain) {
  if (!fixture_->CanUnplug()) GTEST_SKIP() << "nothing can be unplugged here";
  const std::size_t board = expected_.size() / 2;
  fixture_->Unplug(board);
  const Status refused = ring_->Reopen(In(milliseconds(500)));
  ASSERT_FALSE(refused);
  fixture_->Replug(board);
  fixture_->clock().SleepUntil(In(seconds(1)));
  ExpectUnusable(refused.error());
  const Status reopened = ring_->Reopen(In(seconds(3)));
  ASSERT_TRUE(reopened) << reopened.error().Text();
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 3);
}

TEST_P(RangeRingContract, StartsNotWithBoardsThatChangedPlacesUntilTheyAreBack) {
  if (!fixture_->CanSwap()) GTEST_SKIP() << "nothing can be swapped here";
  fixture_->Swap(0, expected_.size() - 1);
  const Status refused = ring_->Reopen(In(seconds(3)));
  ASSERT_FALSE(refused);
  ExpectNamed(refused.error().Text(), 0);
  ExpectNamed(refused.error().Text(), expected_.size() - 1);
  ExpectUnusable(refused.error());
  fixture_->Swap(0, expected_.size() - 1);
  const Status reopened = ring_->Reopen(In(seconds(3)));
  ASSERT_TRUE(reopened) << reopened.error().Text();
  ASSERT_TRUE(ring_->Start(fixture_->level_rate()));
  ExpectLevels(0, 3);
}

}  // namespace annulus::contract
