// That the kernel finds all boards behind its USB host controller, shown without our adapter.

#include <gtest/gtest.h>

#include "base/clock.h"
#include "tests/hil/guest/machine.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::hil {
namespace {

TEST(UsbPlatform, TheKernelFindsTwelveBoardsAndLosesAndFindsOneAgain) {
  SystemClock clock;
  ASSERT_TRUE(WaitForBoards(clock));
  Shell("cat /sys/bus/usb/devices/*/serial | grep -x -c -E 'RB10(0[1-9]|1[0-2])' | grep -x 12");
  Unplug(5);
  Shell("for i in $(seq 100); do grep -q RB1006 /sys/bus/usb/devices/*/serial || exit 0; sleep 0.1; done; exit 1");
  Plug(5);
  ASSERT_TRUE(WaitForBoards(clock));
}

}  // namespace
}  // namespace annulus::hil
