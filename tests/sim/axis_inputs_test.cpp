#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::uint16_t kVoltageEnabled = 0x0010;

/// Wires whose levels are set by hand, at exact times, and a brake that follows the drive's output at once.
class HandSetWires final : public DriveWiring {
 public:
  HandSetWires(AxisDriveModel& drive, Clock& clock) : drive_(drive), clock_(clock) { drive.Wire(*this); }
  void SetAt(nanoseconds time, DriveInputs inputs) { planned_.emplace_back(time, inputs); }
  void Advance() override {
    while (true) {
      const auto own = drive_.NextChange();
      const bool planned = !planned_.empty() && planned_.front().first <= clock_.Now();
      if (planned && (!own || planned_.front().first <= *own)) {
        inputs_ = planned_.front().second;
        Say(planned_.front().first);
        planned_.erase(planned_.begin());
      } else if (own && *own <= clock_.Now()) {
        Say(*own);
      } else {
        return;
      }
    }
  }
  void DriveChanged() override {
    Advance();
    Say(clock_.Now());
  }
  [[nodiscard]] bool brake_output() const { return brake_output_; }

 private:
  void Say(nanoseconds time) { brake_output_ = drive_.Follow(time, inputs_); }

  AxisDriveModel& drive_;
  Clock& clock_;
  DriveInputs inputs_;
  bool brake_output_ = false;
  std::vector<std::pair<nanoseconds, DriveInputs>> planned_;
};

/// A drive that follows its set-points without lag, 2 mm below its home switch, wired by hand.
class AxisInputs : public testing::Test {
 protected:
  static AxisDriveOptions Options(double sink_mm_s2) {
    AxisDriveOptions options;
    options.lag_s = 0.0;
    options.heartbeat = milliseconds(0);
    options.start_window = milliseconds(0);
    options.start_z_mm = options.home_switch_z_mm - 2.0;
    options.sink_mm_s2 = sink_mm_s2;
    return options;
  }
  void Make(double sink_mm_s2 = 0.0) {
    drive_ = std::make_unique<AxisDriveModel>(Options(sink_mm_s2), clock_);
    wires_ = std::make_unique<HandSetWires>(*drive_, clock_);
  }
  std::vector<std::uint16_t> Write(std::uint16_t control, std::uint16_t mode = kModeProfilePosition) {
    // 500 mm, 300 mm/s, 1500 mm/s^2.
    const auto reply = drive_->Transact({ModbusFunction::kWriteReadRegisters,
                                         0x0000,
                                         {++counter_, control, mode, 0x0007, 0xA120, 0x0004, 0x93E0, 0x0016, 0xE360},
                                         0x0100,
                                         8},
                                        milliseconds(100));
    EXPECT_TRUE(reply);
    return reply ? *reply : std::vector<std::uint16_t>(8, 0);
  }
  void Pass(nanoseconds time) { clock_.SleepUntil(clock_.Now() + time); }
  void Enable() {
    Write(control_word::kShutdown);
    Write(control_word::kSwitchOn);
    Write(control_word::kEnableOperation);
  }
  void Travel() {
    Enable();
    Write(control_word::kEnableOperation | control_word::kStart, kModeHoming);
    Pass(std::chrono::seconds(2));
    Write(control_word::kEnableOperation);
    Write(control_word::kEnableOperation | control_word::kStart);
    Pass(std::chrono::seconds(1));
    ASSERT_NEAR(drive_->TrueSpeed(clock_.Now()), -300.0, 1e-9);
  }
  double Height(nanoseconds time) { return drive_->TrueZ(time); }

  ManualClock clock_;
  std::unique_ptr<AxisDriveModel> drive_;
  std::unique_ptr<HandSetWires> wires_;
  std::uint16_t counter_ = 0;
};

constexpr DriveInputs kClosed{};
constexpr DriveInputs kQuickStopOpen{false, true, true, true};
constexpr DriveInputs kStoAOpen{true, false, true, true};
constexpr DriveInputs kStoBOpen{true, true, false, true};
constexpr DriveInputs kBrakeClosed{true, true, true, false};

TEST_F(AxisInputs, QuickStopStopsOnItsRampFromTheExactTimeAndEndsInAFault) {
  Make();
  Travel();
  const nanoseconds edge = clock_.Now() + nanoseconds(1'234'567);
  wires_->SetAt(edge, kQuickStopOpen);
  Pass(milliseconds(70));
  EXPECT_EQ(Write(control_word::kEnableOperation)[2], 0x5441);
  EXPECT_EQ(drive_->state(), DriveState::kQuickStopActive);
  EXPECT_TRUE(wires_->brake_output());
  Pass(milliseconds(50));
  // v^2 / 2a = 300^2 / 8000
  EXPECT_NEAR(Height(edge) - Height(clock_.Now()), 11.25, 1e-6);
  EXPECT_EQ(drive_->state(), DriveState::kFault);
  EXPECT_FALSE(wires_->brake_output());
  // Closing it moves and enables nothing; after a reset of the fault the drive can be enabled again.
  wires_->SetAt(clock_.Now(), kClosed);
  const double z = Height(clock_.Now());
  Write(control_word::kEnableOperation | control_word::kStart);
  Pass(std::chrono::seconds(60));
  EXPECT_EQ(Height(clock_.Now()), z);
  EXPECT_EQ(drive_->state(), DriveState::kFault);
  Write(control_word::kDisableVoltage);
  Write(control_word::kFaultReset);
  Enable();
  EXPECT_EQ(drive_->state(), DriveState::kOperationEnabled);
}

TEST_F(AxisInputs, EitherStoTakesTheTorqueAtOnce) {
  for (const DriveInputs& open : {kStoAOpen, kStoBOpen}) {
    Make();
    Travel();
    const nanoseconds edge = clock_.Now();
    wires_->SetAt(edge, open);
    const auto status = Write(control_word::kEnableOperation);
    EXPECT_EQ(drive_->state(), DriveState::kFault);
    EXPECT_FALSE(wires_->brake_output());
    EXPECT_EQ(status[1] & kVoltageEnabled, 0);
    EXPECT_EQ(status[2], 0x5442);
    Pass(milliseconds(200));
    EXPECT_NEAR(Height(edge) - Height(clock_.Now()), 11.25, 1e-6);  // friction, as steep as the quick stop
  }
}

TEST_F(AxisInputs, AnOpenInputRefusesEnablingAndItsCodeSaysWhich) {
  Make();
  wires_->SetAt(clock_.Now(), kStoBOpen);
  Enable();
  EXPECT_EQ(drive_->state(), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(Write(0)[2], 0x5442);
  wires_->SetAt(clock_.Now(), kQuickStopOpen);
  Enable();
  EXPECT_EQ(drive_->state(), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(Write(0)[2], 0x5441);
  wires_->SetAt(clock_.Now(), kClosed);
  EXPECT_EQ(Write(0)[2], 0);
  Write(control_word::kEnableOperation);
  EXPECT_EQ(drive_->state(), DriveState::kSwitchOnDisabled);
  Enable();
  EXPECT_EQ(drive_->state(), DriveState::kOperationEnabled);
}

TEST_F(AxisInputs, AnInputThatOpensTakesBackADriveThatWasSwitchedOn) {
  for (const DriveInputs& open : {kStoAOpen, kQuickStopOpen}) {
    Make();
    Write(control_word::kShutdown);
    Write(control_word::kSwitchOn);
    ASSERT_EQ(drive_->state(), DriveState::kSwitchedOn);
    wires_->SetAt(clock_.Now(), open);
    wires_->SetAt(clock_.Now() + milliseconds(1), kClosed);
    Pass(milliseconds(2));
    Write(control_word::kEnableOperation);
    EXPECT_EQ(drive_->state(), DriveState::kSwitchOnDisabled);
  }
}

TEST_F(AxisInputs, IsEnabledOnlyWhenTheBrakeHasReleasedAndTripsWhenItCloses) {
  Make();
  wires_->SetAt(clock_.Now(), kBrakeClosed);
  Enable();
  EXPECT_EQ(drive_->state(), DriveState::kSwitchedOn);
  EXPECT_TRUE(wires_->brake_output());
  EXPECT_EQ(Write(control_word::kEnableOperation)[2], 0x5443);
  wires_->SetAt(clock_.Now(), kClosed);
  Travel();
  wires_->SetAt(clock_.Now(), kBrakeClosed);
  Pass(milliseconds(100));
  EXPECT_NEAR(drive_->TrueSpeed(clock_.Now()), 0.0, 1e-9);
  EXPECT_EQ(drive_->state(), DriveState::kFault);
  EXPECT_EQ(drive_->fault_code(), 0x5443);
}

TEST_F(AxisInputs, AnAxisThatDoesNotLockItselfSinksUntilTheBrakeHasClosed) {
  constexpr double kGravity = 9810.0;
  Make(kGravity);
  Travel();
  const nanoseconds off = clock_.Now();
  const nanoseconds held = off + milliseconds(40);
  wires_->SetAt(off, kStoAOpen);
  wires_->SetAt(held, {true, false, true, false});
  Pass(std::chrono::seconds(1));
  // v t + g t^2 / 2 at v + g t = 692.4 mm/s, and v^2 / 2a of the brake.
  EXPECT_NEAR(Height(off) - Height(held), 300.0 * 0.04 + 0.5 * kGravity * 0.04 * 0.04, 1e-6);
  EXPECT_NEAR(Height(held) - Height(clock_.Now()), 692.4 * 692.4 / 8000.0, 1e-6);
}

TEST_F(AxisInputs, WithoutABrakeItSinksOntoItsBuffer) {
  Make(9810.0);
  Travel();
  wires_->SetAt(clock_.Now(), kStoAOpen);
  Pass(std::chrono::seconds(5));
  EXPECT_NEAR(Height(clock_.Now()), -80.0, 1e-6);
}

TEST_F(AxisInputs, StoAtTheEndOfAQuickStopKeepsTheFirstCause) {
  Make(9810.0);
  Travel();
  const nanoseconds edge = clock_.Now();
  wires_->SetAt(edge, kQuickStopOpen);
  wires_->SetAt(edge + milliseconds(150), {false, true, true, false});
  wires_->SetAt(edge + milliseconds(200), {false, false, false, false});
  Pass(std::chrono::seconds(1));
  EXPECT_NEAR(Height(edge) - Height(clock_.Now()), 11.25, 1e-6);
  EXPECT_EQ(drive_->fault_code(), 0x5441);
}

}  // namespace
}  // namespace annulus::sim
