#include "sim/axis_firmware.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/axis_motion.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::uint32_t kParameterCrc = 0xF357F8EB;

nanoseconds Seconds(double seconds) { return nanoseconds(std::llround(seconds * 1e9)); }

TEST(AxisMotion, FollowsTheTrapezoidOfTheTextbook) {
  AxisMotion motion(1000.0, 0.0);
  motion.MoveTo(Seconds(1.0), 400.0, {300.0, 1500.0});
  // Ramp 0.2 s and 30 mm, cruise 540 mm in 1.8 s, ramp 0.2 s.
  EXPECT_NEAR(motion.At(Seconds(1.1)).z_mm, 1000.0 - 0.5 * 1500.0 * 0.01, 1e-5);
  EXPECT_NEAR(motion.At(Seconds(1.2)).z_mm, 970.0, 1e-5);
  EXPECT_NEAR(motion.At(Seconds(1.2)).speed_mm_s, -300.0, 1e-5);
  EXPECT_NEAR(motion.At(Seconds(2.0)).z_mm, 730.0, 1e-5);
  EXPECT_NEAR(motion.At(Seconds(3.1)).z_mm, 400.0 + 0.5 * 1500.0 * 0.01, 1e-5);
  EXPECT_NEAR(static_cast<double>(motion.rest_time().count()) * 1e-9, 3.2, 1e-8);
  EXPECT_EQ(motion.At(Seconds(9.0)).z_mm, 400.0);
}

TEST(AxisMotion, TurnsAShortMoveIntoATriangle) {
  AxisMotion motion(0.0, 0.0);
  motion.MoveTo(Seconds(0.0), 15.0, {300.0, 1500.0});
  // Peak sqrt(a d) = 150 mm/s after 0.1 s, rest after 0.2 s.
  EXPECT_NEAR(motion.At(Seconds(0.1)).speed_mm_s, 150.0, 1e-5);
  EXPECT_NEAR(static_cast<double>(motion.rest_time().count()) * 1e-9, 0.2, 1e-8);
}

TEST(AxisMotion, LagsBehindARampAsTheEquationSays) {
  // A first-order lag T behind set-point a t^2 / 2 stands at a (t^2/2 - T t + T^2 (1 - exp(-t/T))).
  constexpr double kT = 0.02;
  constexpr double kA = 1500.0;
  AxisMotion motion(0.0, kT);
  motion.MoveTo(Seconds(0.0), 1e6, {1e5, kA});
  for (const double t : {0.005, 0.05, 0.3}) {
    const double expected = kA * (t * t / 2.0 - kT * t + kT * kT * (1.0 - std::exp(-t / kT)));
    EXPECT_NEAR(motion.At(Seconds(t)).z_mm, expected, 1e-6);
    EXPECT_NEAR(motion.At(Seconds(t)).speed_mm_s, kA * (t - kT * (1.0 - std::exp(-t / kT))), 1e-6);
  }
}

TEST(AxisMotion, TurnsRoundInMidMoveAndKeepsItsHistory) {
  AxisMotion motion(0.0, 0.004);
  motion.MoveTo(Seconds(0.0), 1000.0, {300.0, 1500.0});
  const double before = motion.At(Seconds(0.9)).z_mm;
  motion.MoveTo(Seconds(1.0), -50.0, {200.0, 1000.0});
  EXPECT_EQ(motion.At(Seconds(0.9)).z_mm, before);
  // From 270 mm at +300 mm/s: 45 mm to stop, so the farthest is 315.
  EXPECT_NEAR(motion.At(Seconds(1.3)).set_z_mm, 315.0, 1e-4);
  EXPECT_NEAR(motion.At(motion.rest_time() + Seconds(0.2)).z_mm, -50.0, 1e-9);
}

TEST(AxisMotion, NeverJumpsWhateverTheOrders) {
  std::uint64_t state = 7;
  const auto unit = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1.0p-53;
  };
  AxisMotion motion(500.0, 0.004);
  nanoseconds now{0};
  double target = 500.0;
  for (int order = 0; order < 300; ++order) {
    if (unit() < 0.2) {
      motion.Stop(now, 4000.0);
    } else {
      target = 2000.0 * unit();
      motion.MoveTo(now, target, {20.0 + 280.0 * unit(), 500.0 + 1000.0 * unit()});
    }
    const nanoseconds until = now + Seconds(2.0 * unit());
    for (double z = motion.At(now).z_mm; now < until; now += milliseconds(1)) {
      const double next = motion.At(now).z_mm;
      ASSERT_LE(std::abs(next - z), 0.301);
      z = next;
    }
  }
  motion.MoveTo(now, 123.0, {300.0, 1500.0});
  EXPECT_NEAR(motion.At(motion.rest_time() + Seconds(1.0)).z_mm, 123.0, 1e-9);
}

/// A drive with a host that writes whole command blocks.
class AxisDriveTest : public testing::Test {
 protected:
  explicit AxisDriveTest(AxisDriveOptions options = {}) : drive_(options, clock_) {}

  struct Order {
    std::uint16_t control = 0;
    std::uint16_t mode = kModeProfilePosition;
    double target_mm = 0.0;
    double speed_mm_s = 300.0;
  };
  ModbusReply Write(Order order) {
    const auto words = [](double value) {
      const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(value * 1000.0)));
      return std::pair(static_cast<std::uint16_t>(bits >> 16), static_cast<std::uint16_t>(bits));
    };
    const auto [target_high, target_low] = words(order.target_mm);
    const auto [speed_high, speed_low] = words(order.speed_mm_s);
    const auto [acceleration_high, acceleration_low] = words(1500.0);
    return drive_.Transact({ModbusFunction::kWriteReadRegisters,
                            0x0000,
                            {++counter_, order.control, order.mode, target_high, target_low, speed_high, speed_low,
                             acceleration_high, acceleration_low},
                            0x0100,
                            8},
                           milliseconds(100));
  }
  ModbusReply Beat() {
    return drive_.Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {++counter_}, 0x0100, 8}, milliseconds(100));
  }
  /// Lets time pass with a beat every 50 ms.
  void Pass(nanoseconds time) {
    const nanoseconds until = clock_.Now() + time;
    while (clock_.Now() < until) {
      clock_.SleepUntil(clock_.Now() + milliseconds(50));
      ASSERT_TRUE(Beat());
    }
  }
  void EnableAndHome() {
    ASSERT_TRUE(Write({control_word::kShutdown}));
    ASSERT_TRUE(Write({control_word::kSwitchOn}));
    ASSERT_TRUE(Write({control_word::kEnableOperation}));
    ASSERT_EQ(drive_.state(), DriveState::kOperationEnabled);
    ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeHoming}));
    Pass(std::chrono::seconds(20));
    ASSERT_TRUE(drive_.homed());
    ASSERT_TRUE(Write({control_word::kEnableOperation}));
  }
  void Move(double target_mm) {
    ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, target_mm}));
    ASSERT_TRUE(Write({control_word::kEnableOperation, kModeProfilePosition, target_mm}));
  }

  ManualClock clock_;
  AxisDriveModel drive_;
  std::uint16_t counter_ = 0;
};

TEST(AxisDrive, ObeysSoMuchLaterThanItAnswers) {
  ManualClock clock;
  AxisDriveOptions options;
  options.reaction = milliseconds(10);
  AxisDriveModel drive(options, clock);
  const nanoseconds sent = clock.Now();
  const ModbusReply reply = drive.Transact(
      {ModbusFunction::kWriteReadRegisters, 0x0000, {1, control_word::kShutdown}, 0x0100, 2}, milliseconds(100));
  ASSERT_TRUE(reply);
  EXPECT_EQ((*reply)[0], 1);  // the echo is of the registers, not of what was obeyed
  EXPECT_EQ(DriveStateOf((*reply)[1]), DriveState::kSwitchOnDisabled);
  clock.SleepUntil(sent + milliseconds(10));
  static_cast<void>(drive.TrueZ(clock.Now()));
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
  clock.SleepUntil(sent + milliseconds(20));
  static_cast<void>(drive.TrueZ(clock.Now()));
  EXPECT_EQ(drive.state(), DriveState::kReadyToSwitchOn);
}

TEST_F(AxisDriveTest, HomesOnItsSwitchAndThenReadsTrueHeights) {
  EnableAndHome();
  Move(1234.0);
  Pass(std::chrono::seconds(5));
  EXPECT_NEAR(drive_.TrueZ(clock_.Now()), 1234.0, 0.002);
  const auto reply = Beat();
  ASSERT_TRUE(reply);
  const auto position_um = static_cast<std::int32_t>(static_cast<std::uint32_t>((*reply)[3]) << 16 | (*reply)[4]);
  EXPECT_NEAR(position_um, 1'234'000, 2);
}

TEST_F(AxisDriveTest, DoesNotMoveUnlessEnabledAndHomed) {
  ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, 100.0}));
  EXPECT_EQ(drive_.state(), DriveState::kSwitchOnDisabled);
  ASSERT_TRUE(Write({control_word::kShutdown}));
  ASSERT_TRUE(Write({control_word::kSwitchOn}));
  ASSERT_TRUE(Write({control_word::kEnableOperation}));
  ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, 100.0}));
  Pass(std::chrono::seconds(1));
  EXPECT_TRUE(drive_.motion_log().empty());
  EXPECT_EQ(drive_.TrueZ(clock_.Now()), drive_.options().start_z_mm);
}

TEST_F(AxisDriveTest, StopsWithin200MillisecondsAndARampWhenTheHostFallsSilent) {
  EnableAndHome();
  Move(500.0);
  Pass(std::chrono::seconds(2));
  const nanoseconds last_beat = clock_.Now();
  EXPECT_NEAR(drive_.TrueSpeed(last_beat), -300.0, 0.01);
  EXPECT_NEAR(drive_.TrueSpeed(last_beat + milliseconds(190)), -300.0, 0.01);
  // 300 mm/s at 4 m/s^2 take 75 ms; 25 ms more for the lag.
  EXPECT_NEAR(drive_.TrueSpeed(last_beat + milliseconds(300)), 0.0, 0.5);
  EXPECT_EQ(drive_.fault_code(), 0x8130);
  clock_.SleepUntil(last_beat + milliseconds(400));
  ASSERT_TRUE(Beat());
  EXPECT_EQ(drive_.state(), DriveState::kFault);
  const std::size_t motions = drive_.motion_log().size();
  Move(600.0);
  EXPECT_EQ(drive_.motion_log().size(), motions);
}

TEST_F(AxisDriveTest, RefusesTargetsBeyondItsSoftLimits) {
  EnableAndHome();
  const std::size_t motions = drive_.motion_log().size();
  ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, 2250.5}));
  EXPECT_EQ(drive_.fault_code(), 0x8612);
  EXPECT_EQ(drive_.motion_log().size(), motions);
}

TEST_F(AxisDriveTest, AnswersExceptionTwoOutsideItsRegisters) {
  const auto refused = [this](const ModbusRequest& request) {
    const ModbusReply reply = drive_.Transact(request, milliseconds(100));
    return !reply && reply.error().fault == ModbusFault::kException && reply.error().exception_code == 2;
  };
  EXPECT_TRUE(refused({ModbusFunction::kReadRegisters, 0, {}, 0x0118, 1}));
  EXPECT_TRUE(refused({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 0}));
  EXPECT_TRUE(refused({ModbusFunction::kReadRegisters, 0, {}, 0x0009, 1}));
  EXPECT_TRUE(refused({ModbusFunction::kWriteRegister, 0x0100, {1}, 0, 0}));
  EXPECT_TRUE(refused({ModbusFunction::kWriteRegisters, 0x0008, {1, 2}, 0, 0}));
  EXPECT_TRUE(refused({ModbusFunction::kWriteRegisters, 0xFFFF, {1}, 0, 0}));
  EXPECT_TRUE(refused({ModbusFunction::kWriteReadRegisters, 0x0000, {}, 0x0100, 8}));
}

TEST_F(AxisDriveTest, ReadsBackItsCommandRegistersByFunctionThree) {
  ASSERT_TRUE(drive_.Transact({ModbusFunction::kWriteRegister, 0x0000, {77}, 0, 0}, milliseconds(100)));
  const auto reply = drive_.Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0000, 2}, milliseconds(100));
  ASSERT_TRUE(reply);
  EXPECT_EQ(*reply, (std::vector<std::uint16_t>{77, 0}));
}

TEST_F(AxisDriveTest, CarriesARequestOutThoughItsReplyIsTooLate) {
  const auto reply =
      drive_.Transact({ModbusFunction::kWriteRegister, 0x0000, {55}, 0, 0}, std::chrono::microseconds(1));
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().fault, ModbusFault::kTimeout);
  const auto read = drive_.Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0000, 1}, milliseconds(100));
  ASSERT_TRUE(read);
  EXPECT_EQ((*read)[0], 55);
}

TEST_F(AxisDriveTest, QuickStopIsSteeperThanHaltAndHoldsUntilPowerIsTakenOff) {
  EnableAndHome();
  Move(500.0);
  Pass(std::chrono::seconds(2));
  ASSERT_TRUE(Write({control_word::kQuickStop}));
  const nanoseconds ordered = clock_.Now();
  EXPECT_EQ(drive_.state(), DriveState::kQuickStopActive);
  EXPECT_NEAR(drive_.TrueSpeed(ordered + milliseconds(105)), 0.0, 0.5);
  ASSERT_TRUE(Write({control_word::kEnableOperation}));
  EXPECT_EQ(drive_.state(), DriveState::kQuickStopActive);
  ASSERT_TRUE(Write({control_word::kDisableVoltage}));
  EXPECT_EQ(drive_.state(), DriveState::kSwitchOnDisabled);
  EXPECT_TRUE(drive_.homed());
}

TEST_F(AxisDriveTest, ObeysAStartOnlyWithinItsWindow) {
  EnableAndHome();
  const std::size_t motions = drive_.motion_log().size();
  ASSERT_TRUE(Write({control_word::kEnableOperation}));
  clock_.SleepUntil(clock_.Now() + milliseconds(26));
  ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, 500.0}));
  EXPECT_EQ(drive_.motion_log().size(), motions);
  EXPECT_EQ(drive_.late_starts(), 1);
  ASSERT_TRUE(Write({control_word::kEnableOperation}));
  ASSERT_TRUE(Write({control_word::kEnableOperation | control_word::kStart, kModeProfilePosition, 500.0}));
  EXPECT_EQ(drive_.motion_log().size(), motions + 1);
}

TEST_F(AxisDriveTest, LetsItsParametersBeReadAndChangedAndSumsThemUp) {
  using P = AxisParameterRegisters;
  const auto read = [this](std::uint16_t address, std::uint16_t count) {
    return drive_.Transact({ModbusFunction::kReadRegisters, 0, {}, address, count}, milliseconds(100));
  };
  const auto before = read(0x0116, 2);
  ASSERT_TRUE(before);
  // CRC-32C of the 18 parameter registers, high bytes first, by a bitwise CRC-32C in Python:
  //   import struct
  //   p = struct.pack(">iiIIIIIIHH", -60000, 2250000, 300000, 1500000, 4000000, 5000, 60000, 10000, 200, 25)
  //   c = 0xFFFFFFFF
  //   for b in p:
  //     c ^= b
  //     for _ in range(8): c = c >> 1 ^ (0x82F63B78 if c & 1 else 0)
  //   print(hex(c ^ 0xFFFFFFFF))
  EXPECT_EQ(static_cast<std::uint32_t>((*before)[0]) << 16 | (*before)[1], kParameterCrc);
  ASSERT_TRUE(drive_.Transact({ModbusFunction::kWriteRegisters, P::kMaxSpeed, {0, 50'000}, 0, 0}, milliseconds(100)));
  EXPECT_EQ(*read(P::kMaxSpeed, 2), (std::vector<std::uint16_t>{0, 50'000}));
  EXPECT_EQ(*read(0x0110, 2), (std::vector<std::uint16_t>{0, 50'000}));
  EXPECT_NE(*read(0x0116, 2), *before);
  const auto refused =
      drive_.Transact({ModbusFunction::kWriteRegisters, P::kMaxSpeed, {0, 0}, 0, 0}, milliseconds(100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().exception_code, 3);
  EXPECT_FALSE(drive_.Transact({ModbusFunction::kWriteRegister, 0x0002, {3}, 0, 0}, milliseconds(100)));
}

TEST_F(AxisDriveTest, KeepsALogOfWritesButNotOfBeats) {
  ASSERT_TRUE(Beat());
  ASSERT_TRUE(Write({control_word::kShutdown}));
  ASSERT_TRUE(Beat());
  ASSERT_EQ(drive_.write_log().size(), 1U);
  EXPECT_EQ(drive_.write_log()[0].address, 0x0000);
  EXPECT_EQ(drive_.write_log()[0].values.at(1), control_word::kShutdown);
}

TEST_F(AxisDriveTest, ForgetsHomeAndOrdersWhenThePowerFails) {
  EnableAndHome();
  Move(500.0);
  Pass(std::chrono::seconds(1));
  drive_.PowerCycle();
  clock_.SleepUntil(clock_.Now() + milliseconds(200));
  ASSERT_TRUE(Beat());
  EXPECT_EQ(drive_.state(), DriveState::kSwitchOnDisabled);
  EXPECT_FALSE(drive_.homed());
  EXPECT_NEAR(drive_.TrueSpeed(clock_.Now()), 0.0, 0.5);
}

}  // namespace
}  // namespace annulus::sim
