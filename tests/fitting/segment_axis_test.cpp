#include "fitting/segment_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/fitting/ring_scene.h"

namespace annulus {
namespace {

/// What a ring sees of one slanted limb of radius 45 mm that stands 250 mm away: rather less than a half of it.
std::vector<SurfaceSample> Limb() {
  test::RingScene scene;
  scene.columns = {{200.0, 100.0, 45.0, 45.0, 0.0, 400.0, 0.2, -0.1}};
  scene.z_max = 400.0;
  return scene.Scan();
}

Eigen::Vector2d TrueCentre(double z) { return {200.0 + 0.2 * z, 100.0 - 0.1 * z}; }

TEST(SegmentAxis, LiesWellInsideALimbThatIsSeenFromOneSide) {
  const auto axis = FindSegmentAxis(Limb());
  ASSERT_TRUE(axis.has_value()) << axis.error().Text();
  for (double z = 0.0; z <= 400.0; z += 20.0) EXPECT_LT((axis->At(z) - TrueCentre(z)).norm(), 12.0) << z;
}

TEST(SegmentAxis, IsNotBentByAFewLevelsThatStandOut) {
  std::vector<SurfaceSample> samples = Limb();
  for (SurfaceSample& sample : samples) {
    if (sample.z < 20.0) sample.radius += 150.0;  // a foot
  }
  const auto axis = FindSegmentAxis(samples);
  ASSERT_TRUE(axis.has_value()) << axis.error().Text();
  for (double z = 20.0; z <= 400.0; z += 20.0) EXPECT_LT((axis->At(z) - TrueCentre(z)).norm(), 20.0) << z;
}

TEST(SegmentAxis, FollowsAnElbow) {
  std::vector<SurfaceSample> samples = Limb();
  for (SurfaceSample& sample : samples) {
    Eigen::Vector3d point = sample.Point();
    point.y() += 60.0 * std::pow(sample.z / 200.0 - 1.0, 2);
    sample.theta = WrapAngle(std::atan2(point.y(), point.x()));
    sample.radius = point.head<2>().norm();
  }
  const auto axis = FindSegmentAxis(samples);
  ASSERT_TRUE(axis.has_value()) << axis.error().Text();
  for (double z = 0.0; z <= 400.0; z += 20.0) {
    const Eigen::Vector2d centre = TrueCentre(z) + Eigen::Vector2d(0.0, 60.0 * std::pow(z / 200.0 - 1.0, 2));
    EXPECT_LT((axis->At(z) - centre).norm(), 25.0) << z;
  }
}

TEST(SegmentAxis, NeedsEightLevels) {
  std::vector<SurfaceSample> samples = Limb();
  std::erase_if(samples, [](const SurfaceSample& sample) { return sample.level >= 7; });
  EXPECT_FALSE(FindSegmentAxis(samples).has_value());
  EXPECT_FALSE(FindSegmentAxis({}).has_value());
}

TEST(SamplesAboutAxis, KeepThePointsAndNumberDirections) {
  const std::vector<SurfaceSample> samples = Limb();
  const SegmentAxis axis{0.0, {200.0, 100.0}, {0.2, -0.1}, {0.0, 0.0}};
  const std::vector<SurfaceSample> turned = SamplesAboutAxis(samples, axis);
  ASSERT_EQ(turned.size(), samples.size());
  std::set<std::uint16_t> sensors;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    Eigen::Vector3d back = turned[k].Point();
    back.head<2>() += axis.At(turned[k].z);
    EXPECT_LT((back - samples[k].Point()).norm(), 1e-9);
    EXPECT_NEAR(turned[k].radius, 45.0, 1e-9);  // about its true axis the limb is a circle
    EXPECT_EQ(turned[k].level, samples[k].level);
    sensors.insert(turned[k].sensor);
  }
  // The same number is the same direction, wherever the limb was seen from.
  for (const std::uint16_t sensor : sensors) {
    double low = kTwoPi;
    double high = 0.0;
    for (const SurfaceSample& sample : turned) {
      if (sample.sensor != sensor) continue;
      low = std::min(low, sample.theta);
      high = std::max(high, sample.theta);
    }
    EXPECT_LT(high - low, kTwoPi / 24.0);
  }
}

TEST(StarShapedLevels, LeaveOutWhatTurnsBack) {
  std::vector<SurfaceSample> samples = Limb();
  const SegmentAxis axis{0.0, {200.0, 100.0}, {0.2, -0.1}, {0.0, 0.0}};
  for (const char fits : StarShapedLevels(samples, axis)) EXPECT_EQ(fits, 1);
  // On one level the limb lies wholly to one side of the axis.
  for (SurfaceSample& sample : samples) {
    if (sample.level == 30) sample.radius -= 130.0;
  }
  const std::vector<char> fits = StarShapedLevels(samples, axis);
  for (std::size_t k = 0; k < samples.size(); ++k) EXPECT_EQ(fits[k] == 0, samples[k].level == 30);
}

}  // namespace
}  // namespace annulus
