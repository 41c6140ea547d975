// That the machine's serial ports are there: the board's second one, and the USB adapter by its lasting name.

#include <gtest/gtest.h>

#include "tests/hil/guest/machine.h"

namespace annulus::hil {
namespace {

TEST(ModbusPlatform, ASerialPortAndAUsbAdapterByItsIdentityAreThere) {
  Shell("test -c /dev/ttyS1");
  AskHost("adapter plug");
  Shell("udevadm settle --timeout=20; for i in $(seq 100); do [ -d /dev/serial/by-id ] && break; sleep 0.1; done");
  EXPECT_NE(Shell("ls /dev/serial/by-id"), "");
  Shell("test -c /dev/serial/by-id/*");
}

TEST(ModbusPlatform, TheHostAnswersRequests) { EXPECT_EQ(AskHost("echo hello there"), "hello there"); }

}  // namespace
}  // namespace annulus::hil
