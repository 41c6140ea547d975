#include "sim/ring_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace annulus::sim {
namespace {

constexpr double kRadius = 600.0;

/// Mean and sd of what `of` takes from the sensors of 20 rings.
template <class Of>
std::pair<double, double> Spread(const RingErrorOptions& options, Of of) {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RingCalibration ring = RandomRing(kRadius, options, seed);
    const RingCalibration ideal = RingCalibration::Ideal(kRadius);
    for (std::size_t i = 0; i < ring.sensors.size(); ++i) {
      const double value = of(ring.sensors[i], ideal.sensors[i]);
      sum += value;
      squares += value * value;
      ++count;
    }
  }
  const double mean = sum / count;
  return {mean, std::sqrt(squares / count - mean * mean)};
}

TEST(RandomRing, HasErrorsOfTheSizesThatWereAskedFor) {
  // 3600 sensors: an sd is known to 1.2 %, a mean to 1.7 % of it; three times that.
  const auto expect = [](double sd, auto of) {
    const auto [mean, found] = Spread(RingErrorOptions{}, of);
    EXPECT_NEAR(found, sd, 0.036 * sd);
    EXPECT_NEAR(mean, 0.0, 0.051 * sd);
  };
  using Sensor = SensorCalibration;
  expect(1.0, [](const Sensor& real, const Sensor&) { return real.range_offset_mm; });
  expect(0.002, [](const Sensor& real, const Sensor&) { return real.range_scale - 1.0; });
  expect(kPi / 360.0, [](const Sensor& real, const Sensor&) { return real.aim_lateral; });
  expect(kPi / 360.0, [](const Sensor& real, const Sensor&) { return real.aim_vertical; });
  expect(0.5, [](const Sensor& real, const Sensor& ideal) { return real.radius_mm - ideal.radius_mm; });
  expect(0.5, [](const Sensor& real, const Sensor& ideal) { return (real.theta - ideal.theta) * kRadius; });
  expect(0.5, [](const Sensor& real, const Sensor&) { return real.height_mm; });
}

TEST(RandomRing, HasTheCommonErrorsOfAllSensors) {
  RingErrorOptions options;
  options.common_offset_mm = 0.4;
  options.quadratic_per_mm = 3e-6;
  options.pose = {0.3, -0.2, 0.001, -0.002};
  options.position_scale = 1.0003;
  options.slope_x = 2e-4;
  options.range_mm_per_c = 0.01;
  options.reference_c = 22.0;
  const auto [mean, sd] = Spread(options, [](const auto& real, const auto&) { return real.range_offset_mm; });
  EXPECT_NEAR(mean, 0.4, 0.051);
  const RingCalibration ring = RandomRing(kRadius, options, 9);
  EXPECT_EQ(ring.sensors[17].range_quadratic, 3e-6);
  EXPECT_EQ(ring.pose, options.pose);
  EXPECT_EQ(ring.carriage.position_scale, 1.0003);
  EXPECT_EQ(ring.carriage.slope_x, 2e-4);
  EXPECT_TRUE(ring.carriage.knots_z_mm.empty());
  EXPECT_NEAR(ring.AtTemperature(32.0).sensors[5].range_offset_mm - ring.sensors[5].range_offset_mm, 0.1, 1e-12);
  EXPECT_EQ(ring.ring_serial, "SIM-RING-9");
}

TEST(RandomRing, IsIdealWithoutErrors) {
  const RingCalibration ring = RandomRing(kRadius, RingErrorOptions{}.Times(0.0), 5);
  EXPECT_EQ(ring.sensors, RingCalibration::Ideal(kRadius).sensors);
  EXPECT_TRUE(ring.IsPlain());
}

TEST(RandomRing, IsTheSameForTheSameSeedAndNoErrorDependsOnTheSizeOfAnother) {
  RingErrorOptions only_aim = RingErrorOptions{}.Times(0.0);
  only_aim.aim_sd_rad = RingErrorOptions{}.aim_sd_rad;
  const RingCalibration all = RandomRing(kRadius, {}, 3);
  const RingCalibration aim = RandomRing(kRadius, only_aim, 3);
  EXPECT_EQ(all.sensors, RandomRing(kRadius, {}, 3).sensors);
  EXPECT_NE(all.sensors, RandomRing(kRadius, {}, 4).sensors);
  for (std::size_t i = 0; i < 180; ++i) {
    EXPECT_EQ(all.sensors[i].aim_lateral, aim.sensors[i].aim_lateral);
    EXPECT_EQ(all.sensors[i].aim_vertical, aim.sensors[i].aim_vertical);
  }
}

TEST(RandomRing, HasRailsThatBendAsFarAsWasAskedFor) {
  RingErrorOptions options;
  options.bend_mm = 0.3;
  const RingCalibration ring = RandomRing(kRadius, options, 6);
  double largest_x = 0.0;
  double largest_y = 0.0;
  for (double z = 0.0; z <= 2200.0; z += 100.0) {
    largest_x = std::max(largest_x, std::abs(ring.carriage.At(z).x()));
    largest_y = std::max(largest_y, std::abs(ring.carriage.At(z).y()));
  }
  EXPECT_NEAR(largest_x, 0.3, 1e-12);
  EXPECT_NEAR(largest_y, 0.3, 1e-12);
  EXPECT_NE(ring.carriage.At(1000.0).x(), ring.carriage.At(1000.0).y());
}

}  // namespace
}  // namespace annulus::sim
