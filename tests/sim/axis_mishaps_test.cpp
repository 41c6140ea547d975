#include "sim/axis_mishaps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using Kind = AxisMishapKind;

/// A homed axis, driven through its driver; what happens is judged by the model's truth.
class AxisMishapTest : public testing::Test {
 protected:
  void SetUp() override {
    AxisDriveOptions options;
    options.start_z_mm = options.home_switch_z_mm - 5.0;
    drive_ = std::make_unique<AxisDriveModel>(options, clock_);
    auto axis = MakeModbusScanAxis(*drive_, AxisRegisterMap{}, clock_);
    ASSERT_TRUE(axis) << axis.error().Text();
    axis_ = std::move(*axis);
  }
  void Home() {
    ASSERT_TRUE(axis_->Enable());
    ASSERT_TRUE(axis_->StartHoming());
    Pass(seconds(3));
    ASSERT_TRUE(drive_->homed());
  }
  /// Lets time pass, asking where the axis is every 20 ms as the scanner does. Returns the last reading.
  AxisPosition Pass(nanoseconds time) {
    const nanoseconds until = clock_.Now() + time;
    AxisPosition last;
    while (clock_.Now() < until) {
      clock_.SleepUntil(std::min(until, clock_.Now() + milliseconds(20)));
      if (auto position = axis_->Position()) last = *position;
    }
    return last;
  }
  void Move(double z_mm, double speed_mm_s) {
    ASSERT_TRUE(axis_->MoveTo(Millimetres(z_mm), MillimetresPerSecond(speed_mm_s)));
  }
  void Suffer(Kind kind, double value = 0.0, std::uint16_t code = 0) {
    drive_->Suffer({kind, clock_.Now(), nanoseconds::max(), value, code});
  }
  double TrueZ() { return drive_->TrueZ(clock_.Now()); }
  double TrueSpeed() { return drive_->TrueSpeed(clock_.Now()); }

  ManualClock clock_;
  std::unique_ptr<AxisDriveModel> drive_;
  std::unique_ptr<ScanAxis> axis_;
};

TEST_F(AxisMishapTest, ALagTripsTheDriveWhenTheErrorOfTheEquationPassesItsLimit) {
  Home();
  Move(1000.0, 100.0);
  Pass(seconds(2));
  ASSERT_NEAR(TrueSpeed(), -100.0, 0.01);
  const nanoseconds begin = clock_.Now() + milliseconds(7);
  const double before = drive_->TrueZ(clock_.Now()) - 0.7;
  drive_->Suffer({Kind::kLag, begin, nanoseconds::max(), 0.2, 0});
  // e(t) = 0.2 v + (0.004 v - 0.2 v) exp(-t / 0.2) at 100 mm/s passes 5 mm after 0.2 ln(19.6 / 15) = 53.5 ms.
  clock_.SleepUntil(begin + milliseconds(50));
  TrueZ();
  EXPECT_EQ(drive_->fault_code(), 0);
  const double z = before - (5.0 - 20.0 + 0.4 + 19.6 * std::exp(-0.25));
  EXPECT_NEAR(drive_->TrueZ(begin + milliseconds(50)), z, 0.001);
  clock_.SleepUntil(begin + milliseconds(57));
  TrueZ();
  EXPECT_EQ(drive_->fault_code(), 0x8611);
}

TEST_F(AxisMishapTest, AnObstacleStopsTheCarriageAndTheDriveTripsWhereItStands) {
  Home();
  Suffer(Kind::kContact, 2000.0);
  Move(1500.0, 200.0);
  Pass(seconds(2));
  EXPECT_EQ(drive_->fault_code(), 0x8611);
  EXPECT_EQ(TrueZ(), 2000.0);
  EXPECT_EQ(TrueSpeed(), 0.0);
  // Nothing pushes any more, and it does not spring when the obstacle is gone.
  ASSERT_TRUE(axis_->Disable());
  Pass(milliseconds(500));
  drive_->Recover({Kind::kContact, {}, nanoseconds::max(), 2000.0, 0}, clock_.Now());
  Pass(seconds(1));
  EXPECT_NEAR(TrueZ(), 2000.0, 1e-9);
  ASSERT_TRUE(axis_->Enable());
  Move(2100.0, 50.0);
  Pass(seconds(3));
  EXPECT_NEAR(TrueZ(), 2100.0, 0.01);
}

TEST_F(AxisMishapTest, AnOverloadTripsAtTheContactWithItsCode) {
  Home();
  Suffer(Kind::kOverload, 2000.0, 0x7121);
  Move(1500.0, 200.0);
  nanoseconds free = clock_.Now();
  while (clock_.Now() < seconds(10) && drive_->fault_code() == 0) {
    if (TrueZ() > 2000.0) free = clock_.Now();
    Pass(milliseconds(5));
  }
  EXPECT_EQ(drive_->fault_code(), 0x7121);
  EXPECT_EQ(TrueZ(), 2000.0);
  EXPECT_LE(clock_.Now() - free, milliseconds(25));
}

TEST_F(AxisMishapTest, ASlippingBrakeLetsTheCarriageSinkOnlyWithoutPower) {
  Home();
  Suffer(Kind::kSlip, 0.5);
  const double powered = TrueZ();
  Pass(seconds(2));
  EXPECT_NEAR(TrueZ(), powered, 1e-6);
  ASSERT_TRUE(axis_->Disable());
  const double begin = TrueZ();
  const nanoseconds since = clock_.Now();
  const AxisPosition read = Pass(seconds(10));
  const double sunk = 0.5 * std::chrono::duration<double>(clock_.Now() - since).count();
  EXPECT_NEAR(begin - TrueZ(), sunk, 0.01);
  EXPECT_NEAR(read.z.value(), TrueZ(), 0.02);
  ASSERT_TRUE(axis_->Enable());
  const double held = TrueZ();
  Pass(seconds(2));
  EXPECT_NEAR(TrueZ(), held, 0.01);
}

TEST_F(AxisMishapTest, AnEncoderJumpIsReadAndNotTravelled) {
  Home();
  const double true_z = TrueZ();
  const double read = Pass(milliseconds(100)).z.value();
  Suffer(Kind::kEncoderJump, -50.0);
  EXPECT_NEAR(Pass(milliseconds(100)).z.value(), read - 50.0, 0.002);
  EXPECT_NEAR(TrueZ(), true_z, 1e-6);
}

TEST_F(AxisMishapTest, AHomeSwitchThatNeverClosesEndsAtTheBuffer) {
  Suffer(Kind::kHomeNever);
  ASSERT_TRUE(axis_->Enable());
  ASSERT_TRUE(axis_->StartHoming());
  Pass(seconds(3));
  EXPECT_FALSE(drive_->homed());
  EXPECT_NEAR(TrueZ(), drive_->options().home_switch_z_mm + 20.0, 0.01);
}

TEST_F(AxisMishapTest, AHomeSwitchThatNeverOpensIsLeftFiftyMillimetresBehindAndNotBelieved) {
  Suffer(Kind::kHomeStuck);
  const double begin = TrueZ();
  ASSERT_TRUE(axis_->Enable());
  ASSERT_TRUE(axis_->StartHoming());
  Pass(seconds(10));
  EXPECT_FALSE(drive_->homed());
  EXPECT_NEAR(TrueZ(), begin - 50.0, 0.01);
}

TEST_F(AxisMishapTest, AnOpenLimitInputStopsThatWayAndLetsTheOtherWayGo) {
  Home();
  Move(1000.0, 200.0);
  Pass(seconds(2));
  Suffer(Kind::kLowerLimit);
  Pass(milliseconds(300));
  EXPECT_EQ(drive_->fault_code(), 0x5444);
  EXPECT_NEAR(TrueSpeed(), 0.0, 1e-9);
  const double stopped = TrueZ();
  ASSERT_TRUE(axis_->Disable());
  ASSERT_TRUE(axis_->Enable());
  static_cast<void>(axis_->MoveTo(Millimetres(stopped - 100.0), MillimetresPerSecond(50.0)));
  Pass(milliseconds(500));
  EXPECT_NEAR(TrueZ(), stopped, 0.1);
  ASSERT_TRUE(axis_->Disable());
  ASSERT_TRUE(axis_->Enable());
  Move(stopped + 100.0, 50.0);
  Pass(seconds(4));
  EXPECT_NEAR(TrueZ(), stopped + 100.0, 0.1);
}

TEST_F(AxisMishapTest, AFaultOfTheDriveItselfIsReportedByItsCode) {
  Home();
  Move(1000.0, 200.0);
  Pass(seconds(1));
  Suffer(Kind::kDriveFault, 0.0, 0x3210);
  clock_.SleepUntil(clock_.Now() + milliseconds(150));
  TrueZ();
  EXPECT_EQ(drive_->fault_code(), 0x3210);
  EXPECT_EQ(drive_->state(), DriveState::kFault);
  EXPECT_NEAR(TrueSpeed(), 0.0, 0.01);
}

TEST_F(AxisMishapTest, AnUnorderedMoveNeedsNoOrder) {
  const std::size_t orders = drive_->motion_log().size();
  const double begin = TrueZ();
  const nanoseconds since = clock_.Now();
  drive_->Suffer({Kind::kUnorderedMove, since, since + seconds(2), -20.0, 0});
  Pass(seconds(1));
  EXPECT_NEAR(TrueSpeed(), -20.0, 0.01);
  Pass(seconds(3));
  EXPECT_NEAR(TrueZ(), begin - 40.0, 0.2);
  EXPECT_NEAR(TrueSpeed(), 0.0, 1e-9);
  EXPECT_EQ(drive_->motion_log().size(), orders);
}

TEST_F(AxisMishapTest, AWrongSignMovesTheOtherWayAndAWrongScaleTooFar) {
  Home();
  Move(2000.0, 100.0);
  Pass(seconds(4));
  Suffer(Kind::kScale, -1.0);
  Move(1900.0, 100.0);
  Pass(seconds(2));
  EXPECT_NEAR(TrueZ(), 2100.0, 0.01);
  Suffer(Kind::kScale, 1.1);
  Move(1900.0, 100.0);
  Pass(milliseconds(1000));
  EXPECT_NEAR(TrueSpeed(), -110.0, 0.01);
  Pass(seconds(3));
  EXPECT_NEAR(TrueZ(), 2100.0 - 220.0, 0.01);
}

TEST_F(AxisMishapTest, AWrongSignHomesTheWrongWay) {
  const double begin = TrueZ();
  Suffer(Kind::kScale, -1.0);
  ASSERT_TRUE(axis_->Enable());
  ASSERT_TRUE(axis_->StartHoming());
  Pass(seconds(1));
  EXPECT_LT(TrueZ(), begin - 40.0);
  EXPECT_NEAR(TrueSpeed(), -60.0, 0.01);
}

TEST_F(AxisMishapTest, OverspeedBeginsInTheMiddleOfAMoveAndEndsAtTheSamePlace) {
  Home();
  Move(1500.0, 100.0);
  Pass(seconds(2));
  Suffer(Kind::kOverspeed, 1.2);
  Pass(milliseconds(300));
  EXPECT_NEAR(TrueSpeed(), -120.0, 0.01);
  Pass(seconds(6));
  EXPECT_NEAR(TrueZ(), 1500.0, 0.01);
}

TEST_F(AxisMishapTest, StopOrdersAreIgnoredButTheQuickStopInputActs) {
  Home();
  Move(500.0, 100.0);
  Pass(seconds(1));
  Suffer(Kind::kIgnoreStops);
  static_cast<void>(axis_->Halt());
  Pass(milliseconds(300));
  EXPECT_NEAR(TrueSpeed(), -100.0, 0.01);
  static_cast<void>(drive_->Follow(clock_.Now(), {false, true, true, true}));
  clock_.SleepUntil(clock_.Now() + milliseconds(100));
  EXPECT_NEAR(TrueSpeed(), 0.0, 0.01);
}

TEST_F(AxisMishapTest, AnIgnoredQuickStopInputLeavesSafeTorqueOff) {
  Home();
  Move(500.0, 100.0);
  Pass(seconds(1));
  Suffer(Kind::kIgnoreQuickStop);
  static_cast<void>(drive_->Follow(clock_.Now(), {false, true, true, true}));
  Pass(milliseconds(100));
  EXPECT_NEAR(TrueSpeed(), -100.0, 0.01);
  static_cast<void>(drive_->Follow(clock_.Now(), {false, false, false, false}));
  clock_.SleepUntil(clock_.Now() + milliseconds(100));
  EXPECT_NEAR(TrueSpeed(), 0.0, 0.01);
}

TEST_F(AxisMishapTest, APowerFailureLeavesTheCarriageWhereItIsAndForgetsHome) {
  Home();
  Move(1000.0, 200.0);
  Pass(seconds(2));
  const nanoseconds now = clock_.Now();
  drive_->Suffer({Kind::kPowerOff, now, now + seconds(3), 0.0, 0});
  EXPECT_FALSE(drive_->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 1}, milliseconds(30)));
  clock_.SleepUntil(now + milliseconds(200));
  const double z = TrueZ();
  clock_.SleepUntil(now + milliseconds(3100));
  EXPECT_EQ(TrueZ(), z);
  EXPECT_FALSE(drive_->homed());
  EXPECT_TRUE(drive_->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 1}, milliseconds(30)));
  EXPECT_EQ(drive_->state(), DriveState::kSwitchOnDisabled);
}

TEST_F(AxisMishapTest, AnotherMastersParametersAreSeenBeforeTheDriveIsEnabled) {
  Suffer(Kind::kParameter, 5000.0, AxisParameterRegisters::kHeartbeat);
  const Status enabled = axis_->Enable();
  ASSERT_FALSE(enabled);
  EXPECT_EQ(drive_->options().heartbeat, seconds(5));
  Suffer(Kind::kParameter, 250.5, AxisParameterRegisters::kMaxSpeed);
  TrueZ();
  EXPECT_EQ(drive_->options().limits.max_speed.value(), 250.5);
}

TEST_F(AxisMishapTest, TheCarriageNeverJumpsWhateverHappens) {
  Home();
  std::uint64_t state = 3;
  const auto unit = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1.0p-53;
  };
  constexpr std::array kKinds{Kind::kLag,        Kind::kContact,       Kind::kSlip,      Kind::kLowerLimit,
                              Kind::kUpperLimit, Kind::kUnorderedMove, Kind::kOverspeed, Kind::kPowerOff};
  constexpr std::array kValues{0.05, 0.0, 30.0, 0.0, 0.0, -30.0, 1.2, 0.0};
  double z = TrueZ();
  for (int round = 0; round < 300; ++round) {
    const auto which = static_cast<std::size_t>(unit() * kKinds.size());
    const nanoseconds from = clock_.Now() + milliseconds(static_cast<int>(500 * unit()));
    const double value = kKinds[which] == Kind::kContact ? z - 50.0 + 100.0 * unit() : kValues[which];
    drive_->Suffer({kKinds[which], from, from + milliseconds(static_cast<int>(1000 * unit())), value, 0});
    static_cast<void>(axis_->Disable());
    static_cast<void>(axis_->Enable());
    if (!drive_->homed()) static_cast<void>(axis_->StartHoming());
    static_cast<void>(axis_->MoveTo(Millimetres(500.0 + 1500.0 * unit()), MillimetresPerSecond(50.0 + 200.0 * unit())));
    const nanoseconds until = clock_.Now() + milliseconds(static_cast<int>(2000 * unit()));
    for (z = TrueZ(); clock_.Now() < until;) {
      clock_.SleepUntil(clock_.Now() + milliseconds(1));
      const double next = TrueZ();
      // A motor that springs back over 20 mm with 4 ms goes 20 (1 - exp(-1/4)) = 4.4 mm in the first one.
      ASSERT_LE(std::abs(next - z), 4.5) << "round " << round;
      z = next;
      if (clock_.Now().count() % 20'000'000 < 1'000'000) static_cast<void>(axis_->Position());
      z = TrueZ();
    }
  }
}

}  // namespace
}  // namespace annulus::sim
