#include <gtest/gtest.h>

#include "sim/axis_mishaps.h"
#include "tests/firmware_iface/hardwired_booth.h"

namespace annulus {
namespace {

using sim::AxisMishapKind;

/// Mishaps of a drive that is wired to its safety chain; judged by chain, brake and true motion.
class HardwiredMishaps : public HardwiredBooth {
 protected:
  void Suffer(AxisMishapKind kind, double value = 0.0, std::uint16_t code = 0) {
    drive().Suffer({kind, clock_.Now(), nanoseconds::max(), value, code});
  }
  /// True height and brake after the program has seen whatever it has seen.
  void ExpectHeldByTheBrake() {
    EXPECT_NEAR(drive().TrueSpeed(clock_.Now()), 0.0, 0.001);
    EXPECT_FALSE(chain().Level(Signal::kBrakeReleased));
  }
};

TEST_F(HardwiredMishaps, ADriveFaultStopsTheCarriageAndClosesTheBrakeWithoutTheProgram) {
  Travel();
  alive_ = false;
  const nanoseconds fault = clock_.Now();
  Suffer(AxisMishapKind::kDriveFault, 0.0, 0x3210);
  Pass(milliseconds(200));
  ExpectHeldByTheBrake();
  EXPECT_EQ(drive().fault_code(), 0x3210);
  // The ramp, then the brake's own 40 ms.
  EXPECT_LE(When(Signal::kBrakeReleased, false, fault) - fault, milliseconds(75 + 40 + 2));
}

TEST_F(HardwiredMishaps, AContactTripsTheDriveAndTheBrakeHoldsTheCarriageThere) {
  Travel();
  const double height = Height() - 60.0;
  Suffer(AxisMishapKind::kContact, height);
  EXPECT_NE(Watch(milliseconds(600)), "");
  EXPECT_EQ(drive().fault_code(), 0x8611);
  EXPECT_NEAR(Height(), height, 0.001);
  ExpectHeldByTheBrake();
}

TEST_F(HardwiredMishaps, ADriveThatIgnoresStopsIsStoppedByTheQuickStopLine) {
  Travel();
  Suffer(AxisMishapKind::kIgnoreStops);
  static_cast<void>(axis_->QuickStop());
  ASSERT_NEAR(drive().TrueSpeed(clock_.Now()), -kSpeed, 0.1);
  const double begin = Height();
  stop_wanted_ = clock_.Now();
  Pass(milliseconds(10 + 20 + 100));
  EXPECT_NEAR(drive().TrueSpeed(clock_.Now()), 0.0, 0.6);
  EXPECT_LE(begin - Height(), kRampMm + kSpeed * 0.030);
}

TEST_F(HardwiredMishaps, ADriveThatIgnoresItsQuickStopInputTooLosesItsTorque) {
  Travel();
  Suffer(AxisMishapKind::kIgnoreStops);
  Suffer(AxisMishapKind::kIgnoreQuickStop);
  stop_wanted_ = clock_.Now();
  Pass(milliseconds(150));
  ASSERT_NEAR(drive().TrueSpeed(clock_.Now()), -kSpeed, 0.1);
  ASSERT_TRUE(interlock_->Set(Out::kEnable, false));
  // 15 ms drop-out and 200 ms of stop delay until STO opens, then it runs out as steeply as on the quick stop.
  Pass(milliseconds(15 + 200 + 100));
  ExpectHeldByTheBrake();
}

TEST_F(HardwiredMishaps, ASlippingBrakeLetsItSinkOnceItHasClosed) {
  Travel();
  ASSERT_TRUE(axis_->Halt());
  Watch(milliseconds(500));
  ASSERT_TRUE(axis_->Disable());
  Pass(milliseconds(300));
  const double begin = Height();
  Suffer(AxisMishapKind::kSlip, 0.5);
  Pass(seconds(4));
  EXPECT_NEAR(begin - Height(), 2.0, 0.02);
  EXPECT_FALSE(chain().Level(Signal::kBrakeReleased));
}

TEST_F(HardwiredMishaps, WithoutMainsTheBrakeHoldsAndNothingIsAnswered) {
  Travel();
  const nanoseconds off = clock_.Now();
  drive().Suffer({AxisMishapKind::kPowerOff, off, off + seconds(2), 0.0, 0});
  EXPECT_NE(Watch(milliseconds(500)), "");
  ExpectHeldByTheBrake();
  const double height = Height();
  Pass(seconds(3));
  EXPECT_EQ(Height(), height);
  EXPECT_FALSE(drive().homed());
}

}  // namespace
}  // namespace annulus
