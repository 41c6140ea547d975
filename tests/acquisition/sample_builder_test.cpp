#include <gtest/gtest.h>

#include "acquisition/scan.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// An ideal ring of four sensors (0, 90, 180, 270 degrees), R = 500 mm, one level at z = 1000 mm.
Scan OneLevel(const std::vector<double>& ranges_mm) {
  Scan scan;
  scan.header.ring_radius_mm = 500.0;
  scan.header.calibration = RingCalibration::Ideal(500.0, ranges_mm.size());
  ScanLevel level;
  for (const double range_mm : ranges_mm) level.readings.push_back({range_mm, 1000.0, 255});
  scan.levels.push_back(level);
  return scan;
}

TEST(BuildSamples, TakesTheRangeFromTheRadiusOfAnIdealRing) {
  const auto samples = BuildSamples(OneLevel({100.0, 200.0, 300.0, 400.0}));
  ASSERT_EQ(samples.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(samples[i].theta, 0.5 * kPi * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(samples[i].radius, 400.0 - 100.0 * static_cast<double>(i), 1e-9);
    EXPECT_EQ(samples[i].z, 1000.0);
    EXPECT_EQ(samples[i].sensor, i);
    EXPECT_EQ(samples[i].weight, 1.0F);
  }
  EXPECT_NEAR(samples[1].ray_direction.y(), -1.0F, 1e-6F);
}

TEST(BuildSamples, LeavesOutWhatIsNoReturn) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(BuildSamples(OneLevel({kNan, infinite, 0.0, -5.0})).empty());
}

TEST(BuildSamples, LeavesOutPointsBeyondTheAxis) {
  const auto samples = BuildSamples(OneLevel({499.9, 500.0, 500.1, 1200.0}));
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_NEAR(samples[0].radius, 0.1, 1e-9);
}

TEST(BuildSamples, AppliesEveryTermOfTheCalibration) {
  Scan scan = OneLevel({200.0, kNan, kNan, kNan});
  SensorCalibration& sensor = scan.header.calibration.sensors[0];
  sensor.radius_mm = 501.0;
  sensor.range_offset_mm = -1.0;
  sensor.range_scale = 1.01;  // 200 * 1.01 - 1 = 201 mm along the beam
  sensor.height_mm = 2.0;
  sensor.aim_lateral = RadiansFromDegrees(3.0);
  sensor.aim_vertical = RadiansFromDegrees(-2.0);
  // Closed form, sensor on +x: (501, 0, 1002) + 201 * (-cos v cos a, -cos v sin a, sin v), a = 3, v = -2 degrees.
  // python3: v, a = radians(-2), radians(3); x = 501 - 201*cos(v)*cos(a); y = -201*cos(v)*sin(a)
  //          hypot(x, y), degrees(atan2(y, x)) + 360, 1002 + 201*sin(v)
  const auto samples = BuildSamples(scan);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_NEAR(samples[0].radius, 300.58164873257476, 1e-9);
  EXPECT_NEAR(DegreesFromRadians(samples[0].theta), 357.9956187274549, 1e-9);
  EXPECT_NEAR(samples[0].z, 994.9852011627974, 1e-9);
}

TEST(BuildSamples, NumbersTimesAndWeightsComeFromTheLevels) {
  Scan scan = OneLevel({100.0, kNan, kNan, kNan});
  scan.levels[0].time = std::chrono::milliseconds(5000);
  scan.levels.push_back(scan.levels[0]);
  scan.levels[1].time = std::chrono::milliseconds(5250);
  scan.levels[1].index = 9;
  scan.levels[1].sweep = 2;
  scan.levels[1].readings[0].quality = 51;
  const auto samples = BuildSamples(scan);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].time_s, 0.0);
  EXPECT_DOUBLE_EQ(samples[1].time_s, 0.25);
  EXPECT_EQ(samples[1].level, 9U);
  EXPECT_EQ(samples[1].sweep, 2U);
  EXPECT_FLOAT_EQ(samples[1].weight, 0.2F);
}

TEST(BuildSamples, OfAnEmptyScanIsEmpty) { EXPECT_TRUE(BuildSamples(Scan{}).empty()); }

}  // namespace
}  // namespace annulus
