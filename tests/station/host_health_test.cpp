#include "station/host_health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace annulus {
namespace {

using testing::HasSubstr;

/// A kernel's folder of files, as on a small computer.
class HostHealth : public testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(root_);
    Write("class/thermal/thermal_zone0/type", "cpu-thermal");
    Write("class/thermal/thermal_zone0/temp", "61200");
    Write("class/thermal/thermal_zone0/trip_point_0_type", "passive");
    Write("class/thermal/thermal_zone0/trip_point_0_temp", "60000");
    Write("class/thermal/thermal_zone0/trip_point_1_type", "critical");
    Write("class/thermal/thermal_zone0/trip_point_1_temp", "90000");
    Write("class/hwmon/hwmon1/name", "rpi_volt");
    Write("class/hwmon/hwmon1/in0_lcrit_alarm", "0");
    Write("class/hwmon/hwmon2/name", "coretemp");
    Write("class/hwmon/hwmon2/temp1_crit_alarm", "0");
  }
  void Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text << "\n";
  }
  [[nodiscard]] ArmCheck Check(std::size_t index) const { return CheckHostHealth(root_.string()).at(index); }

  std::filesystem::path root_;
};

TEST_F(HostHealth, H9_PassesAComputerWithoutAlarms) {
  EXPECT_EQ(Check(0).name, "temperature");
  EXPECT_TRUE(Check(0).result);
  EXPECT_EQ(Check(1).name, "supply");
  EXPECT_TRUE(Check(1).result);
}

TEST_F(HostHealth, H9_NamesAZoneBeyondItsCriticalTemperature) {
  Write("class/thermal/thermal_zone0/temp", "90500");
  ASSERT_FALSE(Check(0).result);
  EXPECT_THAT(Check(0).result.error().seen, HasSubstr("cpu-thermal at 90 C"));
}

TEST_F(HostHealth, H9_NamesAlarmsOfTemperatureAndSupply) {
  Write("class/hwmon/hwmon1/in0_lcrit_alarm", "1");
  Write("class/hwmon/hwmon2/temp1_crit_alarm", "1");
  EXPECT_THAT(Check(0).result.error().seen, HasSubstr("coretemp temp1_crit_alarm"));
  EXPECT_THAT(Check(1).result.error().seen, HasSubstr("rpi_volt in0_lcrit_alarm"));
}

TEST_F(HostHealth, H9_PassesAComputerThatShowsNothing) {
  for (const ArmCheck& check : CheckHostHealth((root_ / "nowhere").string())) EXPECT_TRUE(check.result);
}

}  // namespace
}  // namespace annulus
