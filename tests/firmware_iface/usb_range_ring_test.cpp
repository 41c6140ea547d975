#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"
#include "tests/firmware_iface/forwarding_usb_port.h"
#include "tests/sim/booth_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::HasSubstr;

constexpr double kExpectedRangeMm = 600.0 - sim::kCylinderRadiusMm;
constexpr Hertz kRate{30.0};

/// A booth whose boards are reached through ports that can go wrong. The carriage stands above the cylinder's foot.
class UsbRangeRingTest : public testing::Test {
 protected:
  explicit UsbRangeRingTest(sim::RingBoardOptions board = {}) : booth_(Options(board)) {
    for (UsbPort* port : booth_.usb_ports()) ports_.push_back(std::make_unique<ForwardingUsbPort>(*port));
  }
  static sim::BoothOptions Options(sim::RingBoardOptions board) {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    options.board = board;
    return options;
  }
  std::vector<UsbPort*> Ports() {
    std::vector<UsbPort*> ports;
    for (const auto& port : ports_) ports.push_back(port.get());
    return ports;
  }
  Result<std::unique_ptr<RangeRing>> Make(UsbRangeRingOptions options = {}) {
    return MakeUsbRangeRing(Ports(), std::move(options), booth_.clock());
  }
  std::unique_ptr<RangeRing> Started() {
    auto ring = Make();
    EXPECT_TRUE(ring) << ring.error().Text();
    const Status started = (*ring)->Start(kRate);
    EXPECT_TRUE(started) << started.error().Text();
    return std::move(*ring);
  }
  Result<RingLevel> Next(RangeRing& ring) { return ring.NextLevel(booth_.clock().Now() + milliseconds(100)); }

  sim::Booth booth_;
  std::vector<std::unique_ptr<ForwardingUsbPort>> ports_;
};

TEST_F(UsbRangeRingTest, KnowsItsBoardsInWhateverOrderTheyArePluggedIn) {
  std::vector<UsbPort*> ports = Ports();
  std::mt19937_64 random(5);
  for (std::size_t i = ports.size() - 1; i > 0; --i) std::swap(ports[i], ports[random() % (i + 1)]);
  const auto ring = MakeUsbRangeRing(ports, {}, booth_.clock());
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_EQ((*ring)->boards().size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ((*ring)->boards()[i].serial, 1001 + i);
    EXPECT_EQ((*ring)->boards()[i].first_sensor, 15 * i);
    EXPECT_EQ((*ring)->boards()[i].firmware_version, "1.2.0");
  }
  EXPECT_EQ((*ring)->limits().sensor_count, 180);
  EXPECT_EQ((*ring)->limits().max_level_rate, Hertz(100.0));
}

TEST_F(UsbRangeRingTest, ReadsEveryLevelOfAllSensors) {
  const auto ring = Started();
  for (std::uint32_t sequence = 0; sequence < 100; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
    ASSERT_EQ(level->range_mm.size(), 180U);
    for (double range : level->range_mm) EXPECT_NEAR(range, kExpectedRangeMm, 0.0006);
    for (const BoardStamp& stamp : level->boards) EXPECT_TRUE(stamp.present);
  }
  EXPECT_EQ(ring->counters().levels, 100U);
  EXPECT_EQ(ring->counters().lost_frames, 0U);
  EXPECT_EQ(ring->counters().rejected_bytes, 0U);
}

TEST_F(UsbRangeRingTest, FiresAllBoardsWithinAMillisecondAndStampsEachOnItsOwnClock) {
  const auto ring = Started();
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level);
    nanoseconds first = nanoseconds::max();
    nanoseconds last{0};
    for (std::size_t i = 0; i < 12; ++i) {
      const nanoseconds fired = booth_.board(i).FireTime(sequence);
      EXPECT_EQ(level->boards[i].device_time, booth_.board(i).DeviceTime(fired));
      EXPECT_GT(level->boards[i].host_arrival, fired);
      first = std::min(first, fired);
      last = std::max(last, fired);
    }
    EXPECT_LE(last - first, milliseconds(1));
  }
}

TEST_F(UsbRangeRingTest, DropsADamagedFrameAndMarksItsSensorsOnly) {
  int frames = 0;
  const auto ring = Started();
  ports_[4]->on_completion = [&](UsbCompletion& completion) {
    // Only frames that come in one piece are counted, so the damage hits exactly one frame.
    if (completion.data.size() == kLevelFrameBytes && ++frames == 5) completion.data[40] ^= std::byte{0x10};
  };
  int damaged = 0;
  for (std::uint32_t sequence = 0; sequence < 30; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    if (!level->boards[4].present) ++damaged;
    for (std::size_t sensor = 0; sensor < 180; ++sensor) {
      if (sensor / 15 == 4 && !level->boards[4].present) {
        EXPECT_TRUE(std::isnan(level->range_mm[sensor]));
      } else {
        EXPECT_NEAR(level->range_mm[sensor], kExpectedRangeMm, 0.0006);
      }
    }
  }
  EXPECT_EQ(damaged, 1);
  EXPECT_EQ(ring->counters().lost_frames, 1U);
  EXPECT_EQ(ring->counters().rejected_frames, 1U);
  EXPECT_EQ(ring->counters().rejected_bytes, kLevelFrameBytes);
}

TEST_F(UsbRangeRingTest, GivesUpOnABoardThatLosesFramesAgainAndAgain) {
  int transfers = 0;
  const auto ring = Started();
  ports_[4]->on_completion = [&](UsbCompletion& completion) {
    if (++transfers % 2 == 0) completion.data.clear();
  };
  Result<RingLevel> level = Next(*ring);
  for (int i = 0; i < 30 && level; ++i) level = Next(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1005"));
  EXPECT_THAT(level.error().Text(), HasSubstr("loses frames"));
  EXPECT_EQ(ring->state(), RangeRing::State::kFailed);
  EXPECT_TRUE(ring->Stop());
}

TEST_F(UsbRangeRingTest, DropsRepeatedFrames) {
  std::vector<std::byte> last;
  const auto ring = Started();
  ports_[2]->on_completion = [&](UsbCompletion& completion) {
    const std::vector<std::byte> fresh = completion.data;
    if (fresh.size() == kLevelFrameBytes) completion.data.insert(completion.data.end(), last.begin(), last.end());
    if (fresh.size() == kLevelFrameBytes) last = fresh;
  };
  for (std::uint32_t sequence = 0; sequence < 30; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level);
    EXPECT_EQ(level->sequence, sequence);
    EXPECT_TRUE(level->boards[2].present);
    EXPECT_EQ(level->boards[2].device_time, booth_.board(2).DeviceTime(booth_.board(2).FireTime(sequence)));
  }
  EXPECT_GT(ring->counters().duplicate_frames, 10U);
}

TEST_F(UsbRangeRingTest, NamesTheBoardThatSaysNothing) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  ports_[9]->on_completion = [](UsbCompletion& completion) { completion.data.clear(); };
  const nanoseconds deadline = booth_.clock().Now() + milliseconds(70);
  const auto level = ring->NextLevel(deadline);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("nothing from ring board 1010 (sensors 135-149"));
  EXPECT_LE(booth_.clock().Now(), deadline);
  EXPECT_TRUE(ring->Stop());
}

TEST_F(UsbRangeRingTest, NamesTheBoardThatIsUnpluggedAndStopsCleanly) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.board(3).UnplugAt(booth_.clock().Now() + milliseconds(20));
  const auto level = Next(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1004"));
  EXPECT_THAT(level.error().Text(), HasSubstr("unplugged"));
  EXPECT_TRUE(ring->Stop());
  EXPECT_EQ(ring->state(), RangeRing::State::kIdle);
  for (const auto& port : ports_) EXPECT_EQ(port->in_flight(), 0U);
}

TEST_F(UsbRangeRingTest, StopsThoughCancelledTransfersEndAsCompleted) {
  const auto ring = Started();
  for (const auto& port : ports_) {
    port->on_completion = [](UsbCompletion& completion) {
      if (completion.status != UsbStatus::kCancelled) return;
      completion.status = UsbStatus::kCompleted;
      completion.data.assign(kLevelFrameBytes, std::byte{0x41});
    };
  }
  ASSERT_TRUE(Next(*ring));
  EXPECT_TRUE(ring->Stop());
  for (const auto& port : ports_) EXPECT_EQ(port->in_flight(), 0U);
}

TEST_F(UsbRangeRingTest, StartsAgainFromSequenceZeroManyTimes) {
  const auto ring = Started();
  for (int run = 0; run < 50; ++run) {
    for (std::uint32_t sequence = 0; sequence < 3; ++sequence) {
      const auto level = Next(*ring);
      ASSERT_TRUE(level) << level.error().Text();
      EXPECT_EQ(level->sequence, sequence);
    }
    ASSERT_TRUE(ring->Stop());
    ASSERT_TRUE(ring->Start(kRate));
  }
}

TEST_F(UsbRangeRingTest, GoesOnAfterOneStallAndGivesUpAfterMany) {
  int stalls = 0;
  const auto ring = Started();
  ports_[1]->on_completion = [&](UsbCompletion& completion) {
    if (stalls-- > 0) completion.status = UsbStatus::kStall;
  };
  stalls = 1;
  ASSERT_TRUE(Next(*ring));
  EXPECT_EQ(ports_[1]->halts_cleared, 1);
  stalls = 100;
  Result<RingLevel> level = Next(*ring);
  for (int i = 0; i < 10 && level; ++i) level = Next(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1002"));
}

TEST_F(UsbRangeRingTest, SaysWhichKernelSettingLacksWhenTransfersDoNotFit) {
  ports_[6]->on_submit = [] { return std::optional(UsbFailure{UsbStatus::kNoMemory, {}}); };
  auto ring = Make();
  ASSERT_TRUE(ring);
  const Status started = (*ring)->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("usbfs_memory_mb"));
  EXPECT_EQ((*ring)->state(), RangeRing::State::kIdle);
  for (const auto& port : ports_) EXPECT_EQ(port->in_flight(), 0U);
}

TEST_F(UsbRangeRingTest, StopsWhenABoardReportsAnEmitterFault) {
  const auto ring = Started();
  ports_[5]->on_completion = [](UsbCompletion& completion) {
    UsbFrameAssembler assembler;
    for (LevelFrame frame : assembler.Push(completion.data)) {
      frame.status = kFrameEmitterFault;
      const auto bytes = EncodeLevelFrame(frame);
      completion.data.assign(bytes.begin(), bytes.end());
    }
  };
  Result<RingLevel> level = Next(*ring);
  for (int i = 0; i < 3 && level; ++i) level = Next(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1006"));
  EXPECT_THAT(level.error().Text(), HasSubstr("emitter fault"));
}

TEST_F(UsbRangeRingTest, RefusesTwoBoardsOfOneNumber) {
  ports_[8]->on_control_in = [](UsbRequest request, std::vector<std::byte>& reply) {
    if (request.request != static_cast<std::uint8_t>(BoardRequest::kIdentify)) return;
    BoardIdentity identity = *DecodeBoardIdentity(reply);
    identity.serial = 1001;
    const auto bytes = EncodeBoardIdentity(identity);
    reply.assign(bytes.begin(), bytes.end());
  };
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("two boards have the number 1001"));
}

TEST_F(UsbRangeRingTest, RefusesAnotherProtocolVersionAndNamesBoth) {
  ports_[8]->on_control_in = [](UsbRequest, std::vector<std::byte>& reply) { reply[4] = std::byte{9}; };
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("board 1009 speaks protocol 9"));
  EXPECT_THAT(ring.error().Text(), HasSubstr("this program speaks 1"));
}

TEST_F(UsbRangeRingTest, RefusesARingWithAMissingBoard) {
  std::vector<UsbPort*> ports = Ports();
  ports.erase(ports.begin() + 6);
  const auto ring = MakeUsbRangeRing(ports, {}, booth_.clock());
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("sensor 90 is expected"));
}

TEST_F(UsbRangeRingTest, PutsBoardsWhereTheConfigurationSays) {
  UsbRangeRingOptions options;
  for (std::uint16_t i = 0; i < 12; ++i) {
    options.first_sensors[1001U + i] = static_cast<std::uint16_t>(15 * ((i + 1) % 12));
  }
  const auto ring = Make(options);
  ASSERT_TRUE(ring) << ring.error().Text();
  EXPECT_EQ((*ring)->boards().front().serial, 1012U);
  options.first_sensors.erase(1003);
  const auto unknown = Make(options);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().Text(), HasSubstr("board 1003 is not in the configuration"));
}

TEST_F(UsbRangeRingTest, SaysInWhichStateACallCameAndWhichItNeeds) {
  auto ring = Make();
  ASSERT_TRUE(ring);
  const auto level = Next(**ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().seen, HasSubstr("idle"));
  EXPECT_THAT(level.error().seen, HasSubstr("streaming"));
  ASSERT_TRUE((*ring)->Start(kRate));
  EXPECT_FALSE((*ring)->Start(kRate));
  EXPECT_TRUE((*ring)->Stop());
  EXPECT_FALSE((*ring)->Start(Hertz(5.0)));
  EXPECT_FALSE((*ring)->Start(Hertz(std::nan(""))));
}

TEST_F(UsbRangeRingTest, ReadsABoardsClockBetweenQuestionAndAnswer) {
  const auto ring = Started();
  for (int i = 0; i < 50; ++i) {
    const auto exchange = ring->ReadClock(3);
    ASSERT_TRUE(exchange);
    EXPECT_GE(exchange->device_time, booth_.board(3).DeviceTime(exchange->host_before));
    EXPECT_LE(exchange->device_time, booth_.board(3).DeviceTime(exchange->host_after));
    EXPECT_LT(exchange->host_after - exchange->host_before, milliseconds(5));
  }
}

/// The same ring when every frame comes in two pieces.
class SplitUsbRangeRingTest : public UsbRangeRingTest {
 protected:
  static sim::RingBoardOptions Split() {
    sim::RingBoardOptions options;
    options.split_share = 1.0;
    return options;
  }
  SplitUsbRangeRingTest() : UsbRangeRingTest(Split()) {}
};

TEST_F(SplitUsbRangeRingTest, PutsFramesTogetherThatComeInPieces) {
  const auto ring = Started();
  for (int i = 0; i < 50; ++i) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    for (double range : level->range_mm) EXPECT_NEAR(range, kExpectedRangeMm, 0.0006);
  }
  EXPECT_EQ(ring->counters().rejected_bytes, 0U);
}

TEST_F(SplitUsbRangeRingTest, CatchesUpWhenTheHostWasAwayForASecond) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.clock().SleepUntil(booth_.clock().Now() + std::chrono::seconds(1));
  for (std::uint32_t sequence = 1; sequence < 40; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
  }
  EXPECT_EQ(ring->counters().lost_frames, 0U);
}

}  // namespace
}  // namespace annulus
