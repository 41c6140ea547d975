#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "tests/firmware_iface/can_frame_text.h"
#include "tests/firmware_iface/can_ring_fixture.h"
#include "tests/firmware_iface/forwarding_can_bus.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::HasSubstr;

class CanRangeRingTest : public testing::Test, public CanRingBench {};

TEST_F(CanRangeRingTest, BootsAndIdentifiesTwelveBoards) {
  const auto ring = Make();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_EQ((*ring)->boards().size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ((*ring)->boards()[i].serial, 1001 + i);
    EXPECT_EQ((*ring)->boards()[i].first_sensor, 15 * i);
    EXPECT_EQ((*ring)->boards()[i].firmware_version, "1.2.0");
    EXPECT_EQ((*ring)->boards()[i].port_path, "can0 node " + std::to_string(i + 1));
  }
  EXPECT_EQ((*ring)->limits().sensor_count, 180);
  EXPECT_EQ((*ring)->limits().min_level_rate, Hertz(15.0));
  // 12 boards x 6 frames x 135 us on one bus of 1 Mbit/s, filled to 80 %.
  EXPECT_NEAR((*ring)->limits().max_level_rate.value(), 0.8 / (72 * 135e-6), 1e-6);
}

TEST_F(CanRangeRingTest, ReadsEveryLevelOfAllSensors) {
  const auto ring = Started();
  for (std::uint32_t sequence = 0; sequence < 400; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
    ASSERT_EQ(level->range_mm.size(), 180U);
    for (double range : level->range_mm) EXPECT_NEAR(range, kExpectedRangeMm, 0.02 + 1e-9);
    for (const BoardStamp& stamp : level->boards) EXPECT_TRUE(stamp.present);
  }
  EXPECT_EQ(ring->counters().levels, 400U);
  EXPECT_EQ(ring->counters().lost_frames, 0U);
  EXPECT_EQ(ring->counters().duplicate_frames, 0U);
  EXPECT_TRUE(ring->Stop());
}

TEST_F(CanRangeRingTest, FiresAllBoardsWithinAMillisecondAndStampsEachOnItsOwnClock) {
  const auto ring = Started();
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level);
    nanoseconds first = nanoseconds::max();
    nanoseconds last{0};
    for (std::size_t i = 0; i < 12; ++i) {
      const nanoseconds fired = booth_.can_board(i).fired().at(sequence);
      const nanoseconds off = booth_.can_board(i).DeviceTime(fired) - level->boards[i].device_time;
      EXPECT_GE(off.count(), 0);
      EXPECT_LT(off.count(), 1000);
      EXPECT_GT(level->boards[i].host_arrival, fired);
      first = std::min(first, fired);
      last = std::max(last, fired);
    }
    EXPECT_LE(last - first, milliseconds(1));
  }
}

TEST_F(CanRangeRingTest, StartsAgainFromSequenceZeroManyTimes) {
  const auto ring = Started();
  for (int run = 0; run < 30; ++run) {
    for (std::uint32_t sequence = 0; sequence < 5; ++sequence) {
      const auto level = Next(*ring);
      ASSERT_TRUE(level) << level.error().Text();
      EXPECT_EQ(level->sequence, sequence);
    }
    ASSERT_TRUE(ring->Stop());
    ASSERT_TRUE(ring->Start(kRate));
  }
}

TEST_F(CanRangeRingTest, ReadsABoardsClockBetweenQuestionAndAnswer) {
  const auto ring = Started();
  for (int i = 0; i < 50; ++i) {
    const auto exchange = ring->ReadClock(3);
    ASSERT_TRUE(exchange) << exchange.error().Text();
    EXPECT_GE(exchange->device_time + milliseconds(0),
              booth_.can_board(3).DeviceTime(exchange->host_before) - nanoseconds(1000));
    EXPECT_LE(exchange->device_time, booth_.can_board(3).DeviceTime(exchange->host_after));
    EXPECT_LT(exchange->host_after - exchange->host_before, milliseconds(20));
  }
}

TEST_F(CanRangeRingTest, ATransferOfAFalseLengthIsEndedAtTheBoardTooAndNotCalledARefusal) {
  ForwardingCanBus bus(*buses_[0]);
  // The answer that begins node 5's firmware version, "1.2.0", announces 9 bytes.
  bus.on_receive = [](CanReception& reception) {
    auto* const frame = std::get_if<CanFrame>(&reception.what);
    if (frame == nullptr || frame->id != 0x585 || frame->data[0] != std::byte{0x41}) return;
    frame->data[4] = std::byte{9};
  };
  const auto ring = MakeCanRangeRing({&bus}, {}, booth_.clock());
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().attempted, HasSubstr("node 5"));
  EXPECT_THAT(ring.error().seen, HasSubstr("06070010h: length does not fit"));
  EXPECT_THAT(ring.error().seen, testing::Not(HasSubstr("the board refuses")));
  std::size_t begun = 0;
  std::vector<std::string> sent;
  for (const CanFrame& frame : buses_[0]->log().sent) {
    if (frame.id != 0x605) continue;
    sent.push_back(TextOf(frame));
    if (sent.back() == "605#400A100000000000") ++begun;
  }
  // Every transfer that was begun was taken back: code 0607 0010h.
  EXPECT_EQ(begun, 4U);
  EXPECT_EQ(std::count(sent.begin(), sent.end(), "605#800A100010000706"), 4);
  EXPECT_EQ(sent.back(), "605#800A100010000706");
}

TEST_F(CanRangeRingTest, AnAnswerStampedBeforeItsQuestionMakesNoFalseBoundOfTheClock) {
  ForwardingCanBus bus(*buses_[0]);
  auto ring = MakeCanRangeRing({&bus}, {}, booth_.clock());
  ASSERT_TRUE(ring) << ring.error().Text();
  // As after a step of the wall clock.
  bus.on_receive = [](CanReception& reception) { reception.host_time -= milliseconds(500); };
  for (std::size_t board = 0; board < 12; ++board) {
    const auto exchange = (*ring)->ReadClock(board);
    ASSERT_TRUE(exchange) << exchange.error().Text();
    EXPECT_LE(booth_.can_board(board).DeviceTime(exchange->host_before), exchange->device_time + nanoseconds(1000));
    EXPECT_GE(booth_.can_board(board).DeviceTime(exchange->host_after), exchange->device_time);
  }
}

}  // namespace
}  // namespace annulus
