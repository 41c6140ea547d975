// That the machine's serial ports are there: the board's second one, and the USB adapter by its lasting name.

#include <gtest/gtest.h>

#include "tests/hil/guest/machine.h"

namespace annulus::hil {
namespace {

TEST(ModbusPlatform, TheBoardsPortAndTheUsbAdapterAreThereWithTheRightsOfTheBooth) {
  Shell("test -c /dev/ttyS1");
  AskHost("adapter plug");
  Shell("for i in $(seq 300); do [ -e /dev/serial/by-id/* ] && exit 0; sleep 0.1; done; exit 1");
  const std::string port = Shell("printf %s $(readlink -f /dev/serial/by-id/*)");
  EXPECT_TRUE(HasRightsOfTheBooth(port)) << port;
  EXPECT_EQ(Shell("cat /sys/bus/usb-serial/devices/*/latency_timer"), "1\n");
}

TEST(ModbusPlatform, TheHostAnswersRequests) { EXPECT_EQ(AskHost("echo hello there"), "hello there"); }

}  // namespace
}  // namespace annulus::hil
