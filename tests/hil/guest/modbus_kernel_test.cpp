// The axis over the kernel's serial drivers: the board's port, and a USB adapter that is pulled and comes back.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "firmware_iface/scan_axis.h"
#include "tests/hil/guest/served_drive.h"

namespace annulus::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// A drive of the host over a serial port of the machine.
class ModbusSerial : public testing::Test {
 protected:
  void Open(std::size_t drive) {
    rig_ = std::make_unique<HostDriveRig>(drive);
    auto axis = MakeModbusScanAxis(rig_->link(), AxisRegisterMap(), clock_, rig_->axis_options());
    ASSERT_TRUE(axis) << axis.error().Text();
    axis_ = std::move(*axis);
  }
  void TearDown() override {
    if (axis_) (void)axis_->Disable();
  }
  [[nodiscard]] nanoseconds In(nanoseconds time) const { return clock_.Now() + time; }
  /// Reads the axis every 30 ms until `holds`, at most 60 s; the last reading.
  template <class Holds>
  AxisPosition Until(Holds holds) {
    AxisPosition last;
    const nanoseconds deadline = In(seconds(60));
    while (clock_.Now() < deadline) {
      const auto position = axis_->Position();
      EXPECT_TRUE(position) << position.error().Text();
      if (!position) return last;
      last = *position;
      if (last.fresh && holds(last)) return last;
      clock_.SleepUntil(In(milliseconds(30)));
    }
    ADD_FAILURE() << "not in 60 s; z " << last.z.value() << " mm";
    return last;
  }
  void Home() {
    const Status enabled = axis_->Enable();
    ASSERT_TRUE(enabled) << enabled.error().Text();
    const Status homing = axis_->StartHoming();
    ASSERT_TRUE(homing) << homing.error().Text();
    Until([](const AxisPosition& p) { return p.homed && !p.moving; });
  }

  SystemClock clock_;
  std::unique_ptr<HostDriveRig> rig_;
  std::unique_ptr<ScanAxis> axis_;
};

TEST_F(ModbusSerial, IdentifiesTheDriveBehindTheBoardsPort) {
  ASSERT_NO_FATAL_FAILURE(Open(kDriveOnBoardPort));
  EXPECT_EQ(axis_->identity().serial, 4711U);
  int fresh = 0;
  for (int i = 0; i < 100; ++i) {
    const auto position = axis_->Position();
    ASSERT_TRUE(position) << position.error().Text();
    if (position->fresh) ++fresh;
  }
  EXPECT_GE(fresh, 95);
}

TEST_F(ModbusSerial, HomesMovesAndIsWhereItSays) {
  ASSERT_NO_FATAL_FAILURE(Open(kDriveOnBoardPort));
  ASSERT_NO_FATAL_FAILURE(Home());
  for (const double z : {2200.0, 2050.0}) {
    const Status moved = axis_->MoveTo(Millimetres(z), MillimetresPerSecond(200.0));
    ASSERT_TRUE(moved) << moved.error().Text();
    const AxisPosition there = Until([&](const AxisPosition& p) { return p.target_reached && !p.moving; });
    EXPECT_NEAR(there.z.value(), z, 0.1);
    EXPECT_NEAR(TruthOf(kDriveOnBoardPort).z_mm, z, 1.0) << "the drive's own knowledge";
  }
  const Status stopped = axis_->QuickStop();
  EXPECT_TRUE(stopped) << stopped.error().Text();
}

TEST_F(ModbusSerial, M7_AFrozenDriveDoesNotMoveWhenItWakesUp) {
  ASSERT_NO_FATAL_FAILURE(Open(kDriveOnBoardPort));
  ASSERT_NO_FATAL_FAILURE(Home());
  const DriveTruth before = TruthOf(kDriveOnBoardPort);
  rig_->Silence();
  EXPECT_FALSE(axis_->MoveTo(Millimetres(1500.0), MillimetresPerSecond(200.0)));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(axis_->MoveTo(Millimetres(1500.0), MillimetresPerSecond(200.0)));
  rig_->Speak();
  clock_.SleepUntil(In(seconds(2)));
  const DriveTruth after = TruthOf(kDriveOnBoardPort);
  EXPECT_EQ(after.motions, before.motions) << "orders to move obeyed after they were reported as failed";
  EXPECT_NEAR(after.z_mm, before.z_mm, 0.5);
}

TEST_F(ModbusSerial, M8_AnAdapterThatComesBackUnderAnotherNameIsFoundByItsIdentity) {
  ASSERT_NO_FATAL_FAILURE(Open(kDriveOnAdapter));
  const std::string name = rig_->device();
  EXPECT_EQ(name.rfind("/dev/serial/by-id/", 0), 0U) << name;
  const auto first = std::filesystem::canonical(name);
  // Somebody else keeps the old device open, so that its number is not free when the adapter comes back.
  const int keeper = ::open(first.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_GE(keeper, 0);
  rig_->Unplug();
  const nanoseconds patience = In(seconds(20));
  bool failed = false;
  while (!failed && clock_.Now() < patience) failed = !axis_->Position();
  EXPECT_TRUE(failed) << "an unplugged adapter is noticed";
  rig_->Plug();
  const Status reopened = axis_->Reopen(In(seconds(30)));
  ASSERT_TRUE(reopened) << reopened.error().Text();
  EXPECT_NE(std::filesystem::canonical(name), first) << "the test must have moved it";
  const auto position = axis_->Position();
  ASSERT_TRUE(position) << position.error().Text();
  EXPECT_FALSE(position->homed);
  ::close(keeper);
}

}  // namespace
}  // namespace annulus::hil
