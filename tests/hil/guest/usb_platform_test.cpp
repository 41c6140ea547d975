// That the kernel finds all boards behind its USB host controller, shown without our adapter.

#include <gtest/gtest.h>

#include <filesystem>

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

TEST(UsbPlatform, TheRulesOfTheBoothGiveAccessAndForbidSleep) {
  SystemClock clock;
  ASSERT_TRUE(WaitForBoards(clock));
  std::size_t boards = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/usb/devices")) {
    const std::string folder = entry.path().string();
    if (!std::filesystem::exists(folder + "/idProduct") || Shell("cat " + folder + "/idProduct") != "a180\n") continue;
    ++boards;
    const std::string node = Shell("cd " + folder + " && printf '/dev/bus/usb/%03d/%03d' $(cat busnum devnum)");
    EXPECT_TRUE(HasRightsOfTheBooth(node)) << node;
    EXPECT_EQ(Shell("cat " + folder + "/power/control"), "on\n") << folder;
  }
  EXPECT_EQ(boards, kBoards);
}

}  // namespace
}  // namespace annulus::hil
