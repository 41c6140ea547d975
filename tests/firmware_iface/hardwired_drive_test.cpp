#include <chrono>
#include <cmath>
#include <string>

#include "tests/firmware_iface/hardwired_booth.h"

namespace annulus {
namespace {

using testing::HasSubstr;

TEST_F(HardwiredBooth, E1_TheEstopAloneStopsTheAxisByTheDrivesRampAndThenTakesItsTorque) {
  Travel();
  mirrors_ = false;  // the program only beats
  const nanoseconds pressed = clock_.Now();
  const double z = Height();
  chain().PressEstopAt(pressed);
  const std::string error = Watch(milliseconds(500));
  EXPECT_NEAR(drive().TrueSpeed(clock_.Now()), 0.0, 1e-9);
  // K1 and K3 drop after 15 ms each.
  EXPECT_EQ(When(Signal::kQuickStopInput, false, pressed), pressed + milliseconds(30));
  EXPECT_NEAR(z - Height(), 0.030 * kSpeed + kRampMm, 1e-3);
  EXPECT_NEAR(drive().TrueSpeed(pressed + milliseconds(29)), -kSpeed, 0.1);
  EXPECT_LE(std::abs(drive().TrueSpeed(pressed + milliseconds(30) + kRampTime)), 0.6);
  // The brake closes 40 ms after the drive has come to rest, before the relay takes torque and brake.
  const nanoseconds braked = When(Signal::kBrakeReleased, false, pressed) - pressed;
  EXPECT_NEAR(std::chrono::duration<double>(braked).count(), 0.030 + 0.075 + 0.040, 1e-6);
  EXPECT_EQ(When(Signal::kStoA, false, pressed), pressed + milliseconds(230));
  EXPECT_EQ(When(Signal::kStoB, false, pressed), pressed + milliseconds(230));
  EXPECT_EQ(drive().state(), DriveState::kFault);
  EXPECT_EQ(drive().fault_code(), 0x5441);  // the cause, not what followed
  EXPECT_THAT(error, HasSubstr("5441h, the drive's quick-stop input opened"));
  EXPECT_THAT(error, HasSubstr("safety chain"));
  EXPECT_EQ(axis_->state(), ScanAxis::State::kFault);
}

TEST_F(HardwiredBooth, E1_AProgramThatMirrorsTheEstopStopsTheAxisWithinATickAndTheRamp) {
  Travel();
  for (int phase = 0; phase < 10; ++phase) {
    const nanoseconds pressed = clock_.Now() + milliseconds(phase);
    Pass(milliseconds(phase));
    const double z = Height();
    chain().PressEstopAt(pressed);
    static_cast<void>(Watch(milliseconds(500)));
    const nanoseconds stopped = When(Signal::kQuickStopInput, false, pressed);
    EXPECT_LE(stopped - pressed, kTick);
    EXPECT_NEAR(z - Height(), std::chrono::duration<double>(stopped - pressed).count() * kSpeed + kRampMm, 1e-3);
    EXPECT_NEAR(drive().TrueSpeed(clock_.Now()), 0.0, 1e-9);
    EXPECT_EQ(drive().fault_code(), 0x5441);
    chain().ReleaseEstopAt(clock_.Now());
    ASSERT_TRUE(axis_->Disable());
    Travel();
  }
}

TEST_F(HardwiredBooth, E7_EnablingIsRefusedWhileTheChainIsOpenAndSaysWhy) {
  const Status early = axis_->Enable();
  ASSERT_FALSE(early);
  EXPECT_THAT(early.error().Text(), HasSubstr("'switch on disabled', fault 5442h, safe torque off"));
  Reset();
  ASSERT_TRUE(interlock_->Set(Out::kQuickStop, false));
  const Status stopped = axis_->Enable();
  ASSERT_FALSE(stopped);
  EXPECT_THAT(stopped.error().Text(), HasSubstr("'switch on disabled', fault 5441h"));
  ASSERT_TRUE(interlock_->Set(Out::kQuickStop, true));
  EXPECT_EQ(drive().state(), DriveState::kSwitchOnDisabled);
  EXPECT_TRUE(axis_->Enable());
  EXPECT_TRUE(chain().Level(Signal::kBrakeReleased));
}

TEST_F(HardwiredBooth, E8_AfterAResetNothingMovesUntilSomebodyOrdersIt) {
  Travel();
  chain().PressEstopAt(clock_.Now());
  static_cast<void>(Watch(milliseconds(500)));
  chain().ReleaseEstopAt(clock_.Now());
  const double z = Height();
  const nanoseconds reset = clock_.Now();
  const std::size_t motions = drive().motion_log().size();
  Reset();
  for (const nanoseconds end = clock_.Now() + seconds(60); clock_.Now() < end;) {
    static_cast<void>(Watch(seconds(1)));
    ASSERT_EQ(Height(), z);
  }
  EXPECT_EQ(drive().motion_log().size(), motions);
  EXPECT_EQ(drive().state(), DriveState::kFault);
  for (const sim::ChainEvent& event : chain().log()) {
    EXPECT_FALSE(event.time > reset && event.signal == Signal::kBrakeReleased && event.level);
  }
  ASSERT_TRUE(axis_->Disable());
  const Status enabled = axis_->Enable();
  ASSERT_TRUE(enabled) << enabled.error().Text();
  EXPECT_EQ(Watch(seconds(1)), "");
  EXPECT_EQ(Height(), z);
}

TEST_F(HardwiredBooth, E11_AWeldedContactOfOneStoLeavesTheOtherToTakeTheTorque) {
  chain().WeldStoA();
  Travel();
  const nanoseconds pressed = clock_.Now();
  chain().PressEstopAt(pressed);
  static_cast<void>(Watch(milliseconds(500)));
  chain().ReleaseEstopAt(clock_.Now());
  EXPECT_TRUE(chain().Level(Signal::kStoA));
  EXPECT_LE(When(Signal::kStoB, false, pressed), pressed + milliseconds(230));
  EXPECT_FALSE(chain().Level(Signal::kBrakeReleased));
  ASSERT_TRUE(axis_->Disable());
  const Status enabled = axis_->Enable();
  ASSERT_FALSE(enabled);
  EXPECT_THAT(enabled.error().Text(), HasSubstr("5442h, safe torque off"));
  chain().PressResetAt(clock_.Now());
  Pass(seconds(1));
  EXPECT_FALSE(chain().Level(Signal::kSafetyRelay));
}

TEST_F(HardwiredBooth, M11_AHostKilledInMidMoveStopsByDriveAndWatchdogAlone) {
  Travel();
  const nanoseconds killed = clock_.Now();
  alive_ = false;  // the chip holds the levels, the drive hears nothing
  Pass(seconds(1));
  const nanoseconds dropped = When(Signal::kQuickStopInput, false, killed);
  EXPECT_LE(dropped - killed, milliseconds(250));
  EXPECT_LE(std::abs(drive().TrueSpeed(dropped + kRampTime)), 0.6);
  EXPECT_LE(When(Signal::kBrakeReleased, false, killed) - killed, milliseconds(500));
  EXPECT_LE(When(Signal::kStoB, false, killed) - killed, milliseconds(450));
  // Its own heartbeat of 200 ms or the chain, whichever came first.
  EXPECT_THAT(drive().fault_code(), testing::AnyOf(0x8130, 0x5441));
  const double z = Height();
  Pass(seconds(60));
  EXPECT_EQ(Height(), z);
}

TEST_F(HardwiredBooth, M11_AHostKilledBehindAGatewayThatKeepsTheDriveHappyIsStoppedByTheWatchdog) {
  for (int phase = 0; phase < 8; ++phase) {  // of the watchdog's pulses, 80 ms
    Travel();
    Pass(milliseconds(10 * phase));
    const nanoseconds killed = clock_.Now();
    alive_ = false;
    for (std::uint16_t beat = 1; clock_.Now() < killed + seconds(1); Pass(milliseconds(20))) {
      ASSERT_TRUE(booth_.axis_link().Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {beat++}, 0x0100, 8},
                                              milliseconds(30)));
    }
    const nanoseconds dropped = When(Signal::kQuickStopInput, false, killed);
    EXPECT_LE(dropped - killed, milliseconds(250));
    EXPECT_NEAR(drive().TrueSpeed(dropped), -kSpeed, 0.1);
    EXPECT_LE(std::abs(drive().TrueSpeed(dropped + kRampTime)), 0.6);
    EXPECT_NEAR(drive().TrueZ(dropped) - Height(), kRampMm, 1e-3);
    EXPECT_EQ(drive().fault_code(), 0x5441);
    alive_ = true;
    ASSERT_TRUE(axis_->Disable());
  }
}

TEST_F(HardwiredBooth, M11_WithoutAWatchdogTheDriveStillStopsByItselfAndClosesItsBrake) {
  chain().WeldWatchdog();
  Travel();
  const nanoseconds killed = clock_.Now();
  alive_ = false;
  Pass(seconds(1));  // in which nobody asks chain or drive
  // 200 ms after the last request, which went out 5 to 10 ms ago, the ramp of 75 ms, then the brake's 40 ms.
  const nanoseconds braked = When(Signal::kBrakeReleased, false, killed) - killed;
  EXPECT_LE(braked, milliseconds(200 + 75 + 40));
  EXPECT_GE(braked, milliseconds(200 + 75 + 40 - 10));
  EXPECT_EQ(drive().fault_code(), 0x8130);
  EXPECT_NEAR(drive().TrueSpeed(killed + braked), 0.0, 0.6);
  EXPECT_TRUE(chain().Level(Signal::kStoA) && chain().Level(Signal::kQuickStopInput));
}

TEST_F(HardwiredBooth, M13_TheStopLineDoesNotWaitForALinkThatIsStuck) {
  Travel();
  line_.Freeze();
  for (int reads = 0; reads < 2; ++reads) static_cast<void>(axis_->Position());
  // What follows waits out the quiet time and a reply.
  const nanoseconds asked = clock_.Now();
  const nanoseconds wanted = asked + milliseconds(7);
  stop_wanted_ = wanted;
  static_cast<void>(axis_->Position());
  EXPECT_GE(clock_.Now() - asked, milliseconds(100));
  const nanoseconds stopped = When(Signal::kQuickStopInput, false, asked);
  EXPECT_LE(stopped - wanted, kTick);
  Pass(seconds(1));
  EXPECT_EQ(drive().fault_code(), 0x5441);
  EXPECT_NEAR(drive().TrueSpeed(stopped), -kSpeed, 0.1);
  EXPECT_LE(std::abs(drive().TrueSpeed(stopped + kRampTime)), 0.6);
  EXPECT_NEAR(drive().TrueZ(stopped) - Height(), kRampMm, 1e-3);
}

}  // namespace
}  // namespace annulus
