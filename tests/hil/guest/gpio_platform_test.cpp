// That gpio-sim is there and makes lines, shown without our adapter.

#include <gtest/gtest.h>

#include "tests/hil/guest/machine.h"

namespace annulus::hil {
namespace {

TEST(GpioPlatform, GpioSimMakesAChipWhoseLinesAreSeenBySysfs) {
  const std::string device = "/sys/kernel/config/gpio-sim/probe";
  Shell("mkdir -p " + device + "/bank0/line0 && echo 4 >" + device + "/bank0/num_lines");
  Shell("echo estop_a >" + device + "/bank0/line0/name && echo 1 >" + device + "/live");
  const std::string chip = Shell("printf %s $(cat " + device + "/bank0/chip_name)");
  const std::string node = Shell("printf %s $(cat " + device + "/dev_name)");
  EXPECT_TRUE(chip.starts_with("gpiochip")) << chip;
  EXPECT_TRUE(HasRightsOfTheBooth("/dev/" + chip));
  const std::string line = "/sys/devices/platform/" + node + "/" + chip + "/sim_gpio0";
  Shell("echo pull-up >" + line + "/pull");
  EXPECT_EQ(Shell("cat " + line + "/value"), "1\n");
  Shell("echo 0 >" + device + "/live && rmdir " + device + "/bank0/line0 " + device + "/bank0 " + device);
}

}  // namespace
}  // namespace annulus::hil
