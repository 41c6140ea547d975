#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/fault_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

TEST(UsbFaults, ABoardUnpluggedAtALevelComesBackAndIsOpenedAgain) {
  FaultyBooth booth(R"({"at": {"level": 10}, "for_s": 0.3, "target": "usb", "kind": "unplug",
                        "args": {"board": 3, "not_ready_s": 0.2}})");
  auto ring = booth.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  const auto levels = booth.TakeLevels(**ring, 30);
  ASSERT_FALSE(levels);
  EXPECT_THAT(levels.error().Text(), HasSubstr("1004"));
  ASSERT_EQ(booth.injector().log().size(), 1U);
  const nanoseconds unplugged = booth.injector().log()[0].time;
  EXPECT_LE(booth.clock().Now() - unplugged, milliseconds(40));
  ASSERT_TRUE((*ring)->Stop());
  const Status reopened = (*ring)->Reopen(booth.clock().Now() + seconds(3));
  ASSERT_TRUE(reopened) << reopened.error().Text();
  EXPECT_GE(booth.clock().Now() - unplugged, milliseconds(500));
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  EXPECT_TRUE(booth.TakeLevels(**ring, 5));
  EXPECT_TRUE((*ring)->Stop());
  EXPECT_TRUE(booth.injector().finished());
}

TEST(UsbFaults, AHubWithoutPowerTakesAllBoardsInTheTimeGiven) {
  FaultyBooth booth(TimeOf("0.5", R"("target": "usb", "kind": "unplug", "args": {"spread_ms": 12})"));
  UsbHost& host = booth.injector().usb_host();
  booth.Pass(milliseconds(499));
  EXPECT_EQ(host.List()->size(), 12U);
  booth.Pass(milliseconds(6));
  EXPECT_GE(host.List()->size(), 4U);
  EXPECT_LE(host.List()->size(), 8U);
  booth.Pass(milliseconds(10));
  EXPECT_TRUE(host.List()->empty());
}

TEST(UsbFaults, ABoardOnAPortThatStaysIsPluggedInAgainInPlace) {
  FaultyBooth booth(TimeOf("0.1", R"("for_s": 0.2, "target": "usb", "kind": "unplug", "args": {"board": 0})"));
  UsbPort& port = *booth.injector().usb_ports()[0];
  const auto ask = [&] { return port.ControlIn({1, 0, 0}, 64, milliseconds(10)).has_value(); };
  EXPECT_TRUE(ask());
  booth.Pass(milliseconds(150));
  EXPECT_FALSE(ask());
  booth.Pass(milliseconds(200));
  EXPECT_TRUE(ask());
}

TEST(UsbFaults, TransfersAreSpoiledAsTheyAreNamed) {
  const auto log = [](const std::string& kind) {
    FaultyBooth booth(R"({"at": {"level": 2}, "target": "usb", "kind": ")" + kind +
                      R"(", "args": {"board": 5, "share": 0.3}})");
    auto ring = booth.OpenRing();
    EXPECT_TRUE(ring);
    EXPECT_TRUE((*ring)->Start(Hertz(50.0)));
    static_cast<void>(booth.TakeLevels(**ring, 60));
    static_cast<void>((*ring)->Stop());
    EXPECT_EQ(booth.injector().usb().log(4).damaged + booth.injector().usb().log(4).shortened, 0U);
    return booth.injector().usb().log(5);
  };
  EXPECT_GT(log("short").shortened, 0U);
  EXPECT_GT(log("zero").emptied, 0U);
  EXPECT_GT(log("long").lengthened, 0U);
  EXPECT_GT(log("damage").damaged, 0U);
  EXPECT_GT(log("timeout").timed_out, 0U);
  EXPECT_GT(log("stall").stalls, 0U);
  EXPECT_GT(log("stall").halts_cleared, 0U);
}

TEST(UsbFaults, WithoutMemoryForTransfersTheRingDoesNotStart) {
  FaultyBooth booth(R"({"at": {"call": 3}, "target": "usb", "kind": "no_memory", "args": {"count": 1}})");
  auto ring = booth.OpenRing();
  ASSERT_TRUE(ring);
  const Status started = (*ring)->Start(Hertz(50.0));
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("usbfs_memory_mb"));
  static_cast<void>((*ring)->Stop());
  EXPECT_TRUE((*ring)->Start(Hertz(50.0)));
  EXPECT_TRUE((*ring)->Stop());
}

TEST(UsbFaults, EqualSerialNumbersAndSwappedBoardsAreRefused) {
  FaultyBooth same(TimeOf("0", R"("target": "usb", "kind": "same_serial", "args": {"board": 2, "other": 7})"));
  const auto twice = same.OpenRing();
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error().Text(), HasSubstr("1008"));

  FaultyBooth swapped(TimeOf("0.1", R"("target": "usb", "kind": "swapped", "args": {"board": 2, "other": 7})") + "," +
                      TimeOf("0.1", R"("for_s": 0.2, "target": "usb", "kind": "unplug")"));
  auto ring = swapped.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  swapped.Pass(seconds(1));
  static_cast<void>((*ring)->Start(Hertz(50.0)));
  static_cast<void>(swapped.TakeLevels(**ring, 5));
  static_cast<void>((*ring)->Stop());
  const Status reopened = (*ring)->Reopen(swapped.clock().Now() + seconds(3));
  ASSERT_FALSE(reopened);
  EXPECT_THAT(reopened.error().Text(), HasSubstr("1008"));
}

/// Levels of a ring whose sensors have this fault from level 5 on.
std::vector<RingLevel> LevelsWith(const std::string& fault, std::size_t count = 20) {
  FaultyBooth booth(R"({"at": {"level": 5}, "target": "sensors", )" + fault + "}");
  auto ring = booth.OpenRing();
  EXPECT_TRUE(ring);
  EXPECT_TRUE((*ring)->Start(Hertz(50.0)));
  auto levels = booth.TakeLevels(**ring, count);
  EXPECT_TRUE(levels) << levels.error().Text();
  EXPECT_TRUE((*ring)->Stop());
  return levels ? *levels : std::vector<RingLevel>(count, RingLevel{0, {}, std::vector<double>(180), {}});
}

TEST(SensorFaults, DeadSensorsSeeNothingAndTheirNeighboursDo) {
  const auto levels = LevelsWith(R"("kind": "dead", "args": {"sensor": 29, "sensors": 3})");
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    EXPECT_FALSE(std::isnan(levels[3].range_mm[sensor]));
    EXPECT_EQ(std::isnan(levels[15].range_mm[sensor]), sensor >= 29 && sensor <= 31) << sensor;
  }
}

TEST(SensorFaults, AWholeBoardCanBeDead) {
  const auto levels = LevelsWith(R"("kind": "dead", "args": {"board": 4})");
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    EXPECT_EQ(std::isnan(levels[15].range_mm[sensor]), sensor / 15 == 4) << sensor;
  }
}

TEST(SensorFaults, ReturnsAreLostInTheShareGiven) {
  const auto levels = LevelsWith(R"("kind": "no_return", "args": {"share": 0.25})", 60);
  int lost = 0;
  int all = 0;
  for (std::size_t level = 10; level < levels.size(); ++level) {
    for (const double range : levels[level].range_mm) {
      lost += std::isnan(range) ? 1 : 0;
      ++all;
    }
  }
  // 9000 draws: 0.25 within five standard deviations.
  EXPECT_NEAR(static_cast<double>(lost) / all, 0.25, 5.0 * std::sqrt(0.25 * 0.75 / all));
}

TEST(SensorFaults, SpikesHaveTheRateAndSizeGiven) {
  const auto levels = LevelsWith(R"("kind": "spikes", "args": {"share": 0.1, "size_mm": 100})", 60);
  int wrong = 0;
  int up = 0;
  int all = 0;
  for (std::size_t level = 10; level < levels.size(); ++level) {
    for (const double range : levels[level].range_mm) {
      const double error = range - FaultyBooth::kTrueRangeMm;
      ++all;
      if (std::abs(error) < 0.01) continue;
      ++wrong;
      up += error > 0.0 ? 1 : 0;
      EXPECT_GE(std::abs(error), 20.0 - 0.001);
      EXPECT_LE(std::abs(error), 100.0 + 0.001);
    }
  }
  EXPECT_NEAR(static_cast<double>(wrong) / all, 0.1, 5.0 * std::sqrt(0.09 / all));
  EXPECT_NEAR(static_cast<double>(up) / wrong, 0.5, 5.0 * std::sqrt(0.25 / wrong));
}

TEST(SensorFaults, AStuckSensorRepeatsItselfWhateverTheNoise) {
  FaultyBooth booth(PlanOf(R"({"at": {"level": 5}, "target": "sensors", "kind": "stuck", "args": {"sensor": 8}})"),
                    CylinderBooth(BeamOptions{}));
  auto ring = booth.OpenRing();
  ASSERT_TRUE(ring);
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  const auto levels = booth.TakeLevels(**ring, 20);
  ASSERT_TRUE(levels);
  for (std::size_t level = 9; level < 20; ++level) {
    EXPECT_EQ((*levels)[level].range_mm[8], (*levels)[8].range_mm[8]);
    EXPECT_NE((*levels)[level].range_mm[9], (*levels)[level - 1].range_mm[9]);
  }
  EXPECT_TRUE((*ring)->Stop());
}

TEST(SensorFaults, ADriftGrowsWithTheTime) {
  const auto levels = LevelsWith(R"("kind": "drift", "args": {"sensor": 100, "speed_mm_s": 2.0})", 60);
  const double rise = levels[59].range_mm[100] - levels[9].range_mm[100];
  EXPECT_NEAR(rise, 2.0 * 50 / 50.0, 0.003);
  EXPECT_NEAR(levels[59].range_mm[101], FaultyBooth::kTrueRangeMm, 0.001);
}

TEST(SensorFaults, LateLevelsKeepTheirOwnStamps) {
  FaultyBooth booth(R"({"at": {"level": 5}, "for_s": 0.5, "target": "sensors", "kind": "late",
                        "args": {"board": 2, "levels": 3}})");
  UsbPort& port = *booth.injector().usb_ports()[2];
  UsbPort& master = *booth.injector().usb_ports()[0];
  const auto rate = EncodeLevelRate(50'000);
  const auto order = [](BoardRequest request) { return UsbRequest{static_cast<std::uint8_t>(request), 0, 0}; };
  ASSERT_TRUE(port.ControlOut(order(BoardRequest::kArm), rate, milliseconds(10)));
  ASSERT_TRUE(master.ControlOut(order(BoardRequest::kArm), rate, milliseconds(10)));
  ASSERT_TRUE(master.ControlOut(order(BoardRequest::kStartSync), {}, milliseconds(10)));
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(port.SubmitBulkIn(kLevelEndpoint, 512));
  UsbFrameAssembler assembler;
  int late = 0;
  for (int level = 0; level < 20;) {
    const auto completion = port.WaitCompletion(booth.clock().Now() + milliseconds(200));
    ASSERT_TRUE(completion);
    for (const LevelFrame& frame : assembler.Push(completion->data)) {
      EXPECT_EQ(frame.sequence, static_cast<std::uint32_t>(level));
      const nanoseconds fired = booth.devices().board(2).FireTime(frame.sequence);
      EXPECT_EQ(frame.device_time, booth.devices().board(2).DeviceTime(fired));
      if (completion->host_time - fired > milliseconds(60)) ++late;
      EXPECT_LE(completion->host_time - fired, milliseconds(63));
      booth.injector().NoteLevel(static_cast<std::uint64_t>(level++));
    }
    ASSERT_TRUE(port.SubmitBulkIn(kLevelEndpoint, 512));
  }
  EXPECT_GE(late, 12);
  for (bool left = true; left;) left = port.WaitCompletion(booth.clock().Now() - seconds(1)).has_value();
}

TEST(SensorFaults, ASilentBoardIsMissed) {
  FaultyBooth booth(R"({"at": {"level": 5}, "target": "sensors", "kind": "silent", "args": {"board": 6}})");
  auto ring = booth.OpenRing();
  ASSERT_TRUE(ring);
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  const auto levels = booth.TakeLevels(**ring, 40);
  ASSERT_FALSE(levels);
  EXPECT_THAT(levels.error().Text(), HasSubstr("1007"));
  static_cast<void>((*ring)->Stop());
}

TEST(SensorFaults, ClocksStandJumpAndWrap) {
  const auto clock = [](FaultyBooth& booth, std::size_t board, nanoseconds time) {
    return booth.devices().board(board).DeviceTime(time);
  };
  FaultyBooth honest{FaultPlan{}};
  FaultyBooth stuck(TimeOf("1", R"("for_s": 2, "target": "sensors", "kind": "clock_stuck", "args": {"board": 1})"));
  EXPECT_EQ(clock(stuck, 1, milliseconds(900)), clock(honest, 1, milliseconds(900)));
  EXPECT_EQ(clock(stuck, 1, seconds(2)) - clock(stuck, 1, milliseconds(1500)),
            clock(honest, 1, seconds(2)) - clock(honest, 1, milliseconds(1500)) - milliseconds(500));
  EXPECT_EQ(clock(honest, 1, seconds(5)) - clock(stuck, 1, seconds(5)), seconds(2));

  FaultyBooth jump(TimeOf("1", R"("target": "sensors", "kind": "clock_jump", "args": {"board": 1, "jump_ms": -250})"));
  EXPECT_EQ(clock(honest, 1, seconds(2)) - clock(jump, 1, seconds(2)), milliseconds(250));
  EXPECT_EQ(clock(honest, 2, seconds(2)), clock(jump, 2, seconds(2)));

  FaultyBooth wrap(TimeOf("0", R"("target": "sensors", "kind": "clock_wrap", "args": {"in_s": 3})"));
  const auto micros = [&](std::size_t board, nanoseconds time) {
    return static_cast<std::uint32_t>(clock(wrap, board, time) / std::chrono::microseconds(1));
  };
  for (std::size_t board = 0; board < 12; ++board) {
    // 20 ppm of 3 s are 60 us.
    EXPECT_GT(micros(board, milliseconds(2999)), 0xFFFF'FFFFU - 2000U);
    EXPECT_LT(micros(board, milliseconds(3001)), 2000U);
  }
}

/// A booth in which each sensor's zero is 0.1 mm times its number.
BoothOptions NumberedSensors() {
  BoothOptions options = CylinderBooth();
  options.calibration = RingCalibration::Ideal(600.0);
  for (std::size_t i = 0; i < 180; ++i) options.calibration->sensors[i].range_offset_mm = 0.1 * static_cast<double>(i);
  return options;
}

TEST(SensorFaults, SwappedChannelsReadEachOthersSensor) {
  const std::string swap =
      TimeOf("0.2", R"("for_s": 0.4, "target": "sensors", "kind": "swapped", "args": {"sensor": 33, "other": 41})");
  FaultyBooth booth(PlanOf(swap), NumberedSensors());
  const auto ring = booth.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(20.0)));
  const auto levels = booth.TakeLevels(**ring, 20);
  ASSERT_TRUE(levels) << levels.error().Text();
  const auto zero_of = [&](std::size_t level, std::size_t channel) {
    return std::lround((FaultyBooth::kTrueRangeMm - (*levels)[level].range_mm[channel]) / 0.1);
  };
  EXPECT_EQ(zero_of(0, 33), 33);
  EXPECT_EQ(zero_of(0, 41), 41);
  EXPECT_EQ(zero_of(8, 33), 41);
  EXPECT_EQ(zero_of(8, 41), 33);
  EXPECT_EQ(zero_of(8, 34), 34);
  EXPECT_EQ(zero_of(19, 33), 33);
}

TEST(SensorFaults, SwappedBoardsReadEachOthersSensors) {
  const std::string swap =
      TimeOf("0", R"("target": "sensors", "kind": "swapped", "args": {"sensor": 30, "other": 75, "sensors": 15})");
  FaultyBooth booth(PlanOf(swap), NumberedSensors());
  const auto ring = booth.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(20.0)));
  const auto levels = booth.TakeLevels(**ring, 1);
  ASSERT_TRUE(levels) << levels.error().Text();
  for (std::size_t i = 0; i < 180; ++i) {
    const std::size_t expected = i >= 30 && i < 45 ? i + 45 : i >= 75 && i < 90 ? i - 45 : i;
    EXPECT_NEAR(FaultyBooth::kTrueRangeMm - levels->front().range_mm[i], 0.1 * static_cast<double>(expected), 1e-3)
        << i;
  }
}

TEST(SensorFaults, WrongVersionsAndPlacesAreRefused) {
  FaultyBooth protocol(TimeOf("0", R"("target": "sensors", "kind": "protocol", "args": {"board": 5, "version": 9})"));
  const auto ring = protocol.OpenRing();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("9"));
  FaultyBooth firmware(TimeOf("0", R"("target": "sensors", "kind": "firmware", "args": {"board": 5, "version": 7})"));
  const auto other = firmware.OpenRing();
  ASSERT_TRUE(other);
  EXPECT_EQ((*other)->boards()[5].firmware_version, "7.2.0");
  FaultyBooth place(TimeOf("0", R"("target": "sensors", "kind": "place", "args": {"board": 5, "sensor": 0})"));
  EXPECT_FALSE(place.OpenRing());
}

TEST(SensorFaults, AnEmitterFaultIsInTheStatusOfEachLevelForItsTime) {
  FaultyBooth booth(
      TimeOf("0.2", R"("for_s": 0.2, "target": "sensors", "kind": "emitter_fault", "args": {"board": 0})"));
  UsbPort& port = *booth.injector().usb_ports()[0];
  const auto order = [](BoardRequest request) { return UsbRequest{static_cast<std::uint8_t>(request), 0, 0}; };
  ASSERT_TRUE(port.ControlOut(order(BoardRequest::kArm), EncodeLevelRate(50'000), milliseconds(10)));
  ASSERT_TRUE(port.ControlOut(order(BoardRequest::kStartSync), {}, milliseconds(10)));
  UsbFrameAssembler assembler;
  for (int level = 0; level < 30;) {
    ASSERT_TRUE(port.SubmitBulkIn(kLevelEndpoint, 512));
    const auto completion = port.WaitCompletion(booth.clock().Now() + milliseconds(200));
    ASSERT_TRUE(completion);
    for (const LevelFrame& frame : assembler.Push(completion->data)) {
      const nanoseconds fired = booth.devices().board(0).FireTime(frame.sequence);
      EXPECT_EQ(frame.status == kFrameEmitterFault, fired >= milliseconds(200) && fired < milliseconds(400));
      ++level;
    }
  }
}

}  // namespace
}  // namespace annulus::sim
