#include <gtest/gtest.h>

#include <cmath>

#include "ring_rig.h"

namespace annulus::test {
namespace {

constexpr std::size_t kFirst = 45;  // board 3 of 12
constexpr std::size_t kSensors = 15;

/// A calibrated ring in which one board was replaced by another of the same make.
TEST(ReplacedBoard, IsCalibratedAloneAgainstTheRingAroundIt) {
  sim::RingErrorOptions errors;
  errors.bend_mm = 0.3;
  errors.pose = {0.0, 0.0, 0.004, -0.002};
  const RingCalibration before = sim::RandomRing(600.0, errors, 1);
  const RingCalibration other = sim::RandomRing(600.0, errors, 2);
  Rig rig = StandardRig(1, errors);
  rig.truth = before;
  for (std::size_t i = kFirst; i < kFirst + kSensors; ++i) rig.truth.sensors[i] = other.sensors[i];
  // Three placements for what a sensor of that board cannot know otherwise: leaning towards it, away from it and to one
  // side, upright to the other side. The board's middle is at 104 degrees.
  rig.plan = {ColumnAt(0, 0.0, 0.0, 8.0, 104.0), ColumnAt(0, 70.0, 14.0, 8.0, 284.0),
              ColumnAt(0, 70.0, 194.0, 0.3, 0.0)};
  CalibrateOptions how;
  how.free_sensors.assign(180, false);
  for (std::size_t i = kFirst; i < kFirst + kSensors; ++i) how.free_sensors[i] = true;
  const auto solution = CalibrateRing(before, rig.Targets(), rig.Scans(), how, {});
  ASSERT_TRUE(solution) << solution.error().Text();

  const RingCalibration& found = solution->calibration;
  EXPECT_TRUE(found.pose == before.pose);
  EXPECT_TRUE(found.carriage == before.carriage);
  for (std::size_t i = 0; i < before.sensors.size(); ++i) {
    if (i >= kFirst && i < kFirst + kSensors) continue;
    EXPECT_TRUE(found.sensors[i] == before.sensors[i]) << i;
    EXPECT_TRUE(solution->sensor_covariance[i].isZero(1e-12)) << i;
  }
  double squares = 0.0;
  double vertical = 0.0;
  double lateral = 0.0;
  int inside = 0;
  int all = 0;
  for (const double distance : {350.0, 450.0, 530.0}) {
    for (std::size_t i = kFirst; i < kFirst + kSensors; ++i) {
      const double reading = rig.truth.sensors[i].ReadingOf(distance);
      const Eigen::Vector3d error = found.PointOf(i, 550.0, reading) - rig.truth.PointOf(i, 550.0, reading);
      const double theta = kTwoPi * static_cast<double>(i) / 180.0;
      const double radial = error.x() * std::cos(theta) + error.y() * std::sin(theta);
      squares += radial * radial / (3.0 * kSensors);
      if (distance != 450.0) continue;
      lateral += std::pow(-error.x() * std::sin(theta) + error.y() * std::cos(theta), 2) / kSensors;
      vertical += error.z() * error.z() / kSensors;
      inside += std::abs(radial) < 1.96 * solution->sensor_sigma_mm[static_cast<Eigen::Index>(i)] ? 1 : 0;
      ++all;
    }
  }
  std::printf(
      "[ figures  ] replaced board: radial %.3f mm, lateral %.4f, vertical %.4f degrees; %d of %d inside 95 %%\n",
      std::sqrt(squares), DegreesFromRadians(std::sqrt(lateral) / 450.0),
      DegreesFromRadians(std::sqrt(vertical) / 450.0), inside, all);
  EXPECT_LE(std::sqrt(squares), 0.15);
  EXPECT_LE(std::sqrt(lateral), 450.0 * RadiansFromDegrees(0.02));
  EXPECT_LE(std::sqrt(vertical), 450.0 * RadiansFromDegrees(0.1));
  EXPECT_GE(inside, 12);
}

}  // namespace
}  // namespace annulus::test
