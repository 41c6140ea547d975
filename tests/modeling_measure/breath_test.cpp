#include "modeling/measure/breath.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "base/frames.h"
#include "base/units.h"

namespace annulus {
namespace {

using testing::HasSubstr;

constexpr double kRateHz = 20.0;
constexpr double kRadius = 130.0;

/// A round trunk whose radius and place change in time, seen by 180 sensors at 1200 mm with noise of 0.5 mm.
struct RoundTrunk {
  std::function<double(double)> radius = [](double) { return kRadius; };
  std::function<Eigen::Vector2d(double)> place = [](double) { return Eigen::Vector2d(15.0, -10.0); };
  double seconds = 16.0;
  double climb_mm_s = 0.0;

  [[nodiscard]] double Girth(double time_s) const { return kTwoPi * radius(time_s); }

  [[nodiscard]] std::vector<SurfaceSample> Samples(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0.0, 0.5);
    std::vector<SurfaceSample> samples;
    for (std::uint32_t level = 0; level < seconds * kRateHz; ++level) {
      for (std::uint16_t sensor = 0; sensor < 180; ++sensor) {
        SurfaceSample sample;
        sample.time_s = level / kRateHz;
        sample.theta = kTwoPi * sensor / 180.0;
        sample.z = 1200.0 + climb_mm_s * sample.time_s;
        sample.level = level;
        sample.sensor = sensor;
        // The cosine rule: r² - 2 r d cos + d² = R².
        const Eigen::Vector2d centre = place(sample.time_s);
        const Eigen::Vector2d outward(std::cos(sample.theta), std::sin(sample.theta));
        const double along = centre.dot(outward);
        const double big = radius(sample.time_s);
        sample.radius = along + std::sqrt(along * along - centre.squaredNorm() + big * big) + noise(random);
        sample.ray_direction = Eigen::Vector3d(-outward.x(), -outward.y(), 0.0).cast<float>();
        samples.push_back(sample);
      }
    }
    return samples;
  }
};

/// Leaning to and fro as people do while they stand: some mm within 20 s.
Eigen::Vector2d Sway(double time_s) {
  return {15.0 + 3.0 * std::sin(0.9 * time_s) + 1.5 * std::sin(2.3 * time_s + 1.0),
          -10.0 + 5.0 * std::sin(0.6 * time_s + 2.0)};
}

RoundTrunk Breathing() {
  RoundTrunk trunk;
  trunk.radius = [](double time_s) { return kRadius * (1.0 + 0.015 * (0.5 - 0.5 * std::cos(kTwoPi * time_s / 4.0))); };
  trunk.place = Sway;
  return trunk;
}

TEST(MeasureBreath, FindsTheGirthsOfABreathWhileThePersonSways) {
  const auto breath = MeasureBreath(Breathing().Samples(1), {});
  ASSERT_TRUE(breath) << breath.error().Text();
  EXPECT_TRUE(breath->breathing);
  EXPECT_NEAR(breath->min_mm.value, kTwoPi * kRadius, 0.3);
  EXPECT_NEAR(breath->mean_mm.value, kTwoPi * kRadius * 1.0075, 0.3);
  EXPECT_NEAR(breath->max_mm.value, kTwoPi * kRadius * 1.015, 0.3);
  EXPECT_NEAR(breath->amplitude_mm.value, kTwoPi * kRadius * 0.015, 0.4);
  EXPECT_NEAR(breath->period_s, 4.0, 0.1);
  EXPECT_EQ(breath->breaths, 2U);  // breathed out at 4, 8 and 12 s; 0 and 16 s are not within the scan
  EXPECT_GT(breath->measured_share, 0.99);
  EXPECT_EQ(breath->z_mm, 1200.0);
  for (const Uncertain& number : {breath->min_mm, breath->mean_mm, breath->max_mm}) {
    EXPECT_GT(number.sigma, 0.01);
    EXPECT_LT(number.sigma, 0.3);
  }
}

TEST(MeasureBreath, FollowsTheGirthOverTheWholeTimeAndOverOneBreath) {
  const RoundTrunk trunk = Breathing();
  const auto breath = MeasureBreath(trunk.Samples(2), {});
  ASSERT_TRUE(breath) << breath.error().Text();
  EXPECT_GT(breath->course.size(), 150U);
  for (const GirthPoint& point : breath->course) EXPECT_NEAR(point.girth_mm, trunk.Girth(point.time_s), 0.5);
  ASSERT_FALSE(breath->curve.empty());
  EXPECT_EQ(breath->curve.front().time_s, 0.0);
  EXPECT_NEAR(breath->curve.back().time_s, breath->period_s, 1e-9);
  // From breathed out, which here is t = 0, to breathed out; valleys are found to a few tenths of a second.
  for (const GirthPoint& point : breath->curve) EXPECT_NEAR(point.girth_mm, trunk.Girth(point.time_s), 1.5);
  EXPECT_NEAR(breath->curve[20].girth_mm, breath->max_mm.value, 0.3);
}

TEST(MeasureBreath, FollowsBreathsThatAreNotAllAlike) {
  // Breaths of 3.3 to 4.9 s: the phase runs unevenly.
  RoundTrunk trunk = Breathing();
  trunk.seconds = 20.0;
  trunk.radius = [](double time_s) {
    const double phase = kTwoPi * time_s / 4.0 + 0.8 * std::sin(0.5 * time_s);
    return kRadius * (1.0 + 0.01 * (0.5 - 0.5 * std::cos(phase)));
  };
  const auto breath = MeasureBreath(trunk.Samples(3), {});
  ASSERT_TRUE(breath) << breath.error().Text();
  EXPECT_TRUE(breath->breathing);
  EXPECT_NEAR(breath->min_mm.value, kTwoPi * kRadius, 0.3);
  EXPECT_NEAR(breath->max_mm.value, kTwoPi * kRadius * 1.01, 0.3);
  EXPECT_NEAR(breath->period_s, 4.0, 0.5);
}

TEST(MeasureBreath, SaysThatNobodyBreathesWhoOnlySways) {
  for (const std::uint64_t seed : {4U, 5U}) {
    RoundTrunk trunk;
    trunk.place = Sway;
    const auto held = MeasureBreath(trunk.Samples(seed), {});
    ASSERT_TRUE(held) << held.error().Text();
    EXPECT_FALSE(held->breathing);
    EXPECT_EQ(held->breaths, 0U);
    EXPECT_TRUE(held->curve.empty());
    EXPECT_NEAR(held->mean_mm.value, kTwoPi * kRadius, 0.2);
    EXPECT_LT(held->highest_mm - held->lowest_mm, 1.0);
    EXPECT_EQ(held->max_mm.value, held->highest_mm);
  }
}

TEST(MeasureBreath, IsRefusedWhereTheRingMovedOrStoodTooShort) {
  RoundTrunk climbing;
  climbing.climb_mm_s = 20.0;
  const auto moved = MeasureBreath(climbing.Samples(6), {});
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().Text(), HasSubstr("the ring moved"));
  RoundTrunk brief;
  brief.seconds = 2.0;
  const auto short_time = MeasureBreath(brief.Samples(7), {});
  ASSERT_FALSE(short_time);
  EXPECT_THAT(short_time.error().Text(), HasSubstr("lasts 1.95 s"));
  EXPECT_FALSE(MeasureBreath({}, {}));
}

TEST(MeasureBreath, IsRefusedWithTheTimeWhereAPartWasNotSeen) {
  auto samples = Breathing().Samples(8);
  std::erase_if(samples, [](const SurfaceSample& sample) { return sample.sensor >= 20 && sample.sensor < 60; });
  const auto breath = MeasureBreath(samples, {});
  ASSERT_FALSE(breath);
  EXPECT_THAT(breath.error().Text(), HasSubstr("was not seen"));
  EXPECT_THAT(breath.error().Text(), HasSubstr("1200 mm"));
}

}  // namespace
}  // namespace annulus
