#include "tests/hil/guest/served_drive.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <utility>

#include "tests/hil/guest/machine.h"

namespace annulus::hil {
namespace {

/// Waits until udev has made or removed the adapter's name, at most 30 s.
void AwaitAdapter(Clock& clock, bool there) {
  const std::chrono::nanoseconds deadline = clock.Now() + std::chrono::seconds(30);
  while (ListSerialPorts().empty() == there && clock.Now() < deadline) {
    clock.SleepUntil(clock.Now() + std::chrono::milliseconds(20));
  }
  EXPECT_NE(ListSerialPorts().empty(), there) << "the adapter's name in /dev/serial/by-id";
}

}  // namespace

DriveTruth TruthOf(std::size_t drive) {
  DriveTruth truth;
  const std::string told = AskHost("axis state " + std::to_string(drive));
  std::istringstream words(told);
  words >> truth.z_mm >> truth.speed_mm_s >> truth.homed >> truth.motions >> truth.late_starts >> truth.writes;
  EXPECT_FALSE(words.fail()) << told;
  return truth;
}

HostDriveRig::HostDriveRig(std::size_t drive) : drive_(drive) {
  patience = 5.0;  // as tests/hil/axis_server.cpp
  real_time = true;
  AskHost("axis new " + std::to_string(drive_));
  Plug();
  device_ = "/dev/ttyS1";
  if (drive_ == kDriveOnAdapter) device_ = ListSerialPorts().empty() ? "no adapter" : ListSerialPorts().front();
  ModbusRtuOptions options;
  options.device = device_;
  auto opened = OpenModbusRtu(options, clock_);
  EXPECT_TRUE(opened) << opened.error().Text();
  if (opened) link_ = std::move(*opened);
}

HostDriveRig::~HostDriveRig() { Speak(); }

void HostDriveRig::Silence() { AskHost("axis stall " + std::to_string(drive_)); }
void HostDriveRig::Speak() { AskHost("axis resume " + std::to_string(drive_)); }

void HostDriveRig::Unplug() {
  ASSERT_EQ(drive_, kDriveOnAdapter) << "the board's port has no plug that the kernel feels";
  AskHost("adapter unplug");
  AwaitAdapter(clock_, false);
}

void HostDriveRig::Plug() {
  if (drive_ != kDriveOnAdapter) return;
  AskHost("adapter plug");
  AwaitAdapter(clock_, true);
}

}  // namespace annulus::hil
