// Levels and points of simulated persons, scanned with noise, against what their builder knows.

#include "modeling/landmarks/body_landmarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>

#include "fitting/fit_segments.h"
#include "modeling/landmarks/body_levels.h"
#include "modeling/landmarks/landmarks.h"
#include "sim/head.h"
#include "sim/person.h"

namespace annulus {
namespace {

/// What a ring of 180 sensors sees of a subject between two heights, with noise of 0.5 mm and 1 % lost returns.
struct Window {
  double z_min = 0.0;
  double z_max = 0.0;
  double pitch = 5.0;
};
std::vector<SurfaceSample> Scan(const sim::Subject& subject, const Window& window, std::uint64_t seed) {
  constexpr double kRingRadius = 1000.0;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.5);
  std::bernoulli_distribution is_lost(0.01);
  std::vector<SurfaceSample> samples;
  std::uint32_t level = 0;
  for (double z = window.z_min; z < std::min(window.z_max, subject.top_mm() - 2.0); z += window.pitch, ++level) {
    for (std::uint16_t sensor = 0; sensor < 180; ++sensor) {
      const double theta = kTwoPi * sensor / 180.0;
      const Eigen::Vector3d inward = -PointFromCylindrical(theta, 1.0, 0.0);
      const auto hit = subject.Cast({PointFromCylindrical(theta, kRingRadius, z), inward}, 0.0, kRingRadius - 1e-6);
      const double error = noise(random);
      if (is_lost(random) || !hit) continue;
      SurfaceSample sample;
      sample.theta = theta;
      sample.z = z;
      sample.radius = kRingRadius - hit->distance_mm + error;
      sample.ray_direction = inward.cast<float>();
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  return samples;
}

/// A fitted scan and all that was found on it.
struct Found {
  std::unique_ptr<const SurfaceModel> model;
  Landmarks landmarks;
  double front = 0.0;

  Found(const sim::Subject& subject, const Window& window, std::uint64_t seed) {
    auto fit = FitBody(Scan(subject, window, seed), {}, {});
    if (!fit) throw std::runtime_error(fit.error().Text());
    model = std::make_unique<const SurfaceModel>(std::move(fit->model));
    const MeasuredSurface body = Body();
    landmarks = FindLandmarks(body, {});
    front = FindBodyShape(body, {}).front;
  }
  [[nodiscard]] MeasuredSurface Body() const { return *MeasuredSurface::FromModel(*model); }
};

class LandmarksOfAPerson : public testing::TestWithParam<sim::PersonOptions> {};

TEST_P(LandmarksOfAPerson, LieWhereItsBuilderPutThem) {
  const sim::ParametricBody person = sim::MakePerson(GetParam());
  const Found found(person, {0.25 * GetParam().height_mm, 3000.0}, 7);
  const MeasuredSurface body = found.Body();
  EXPECT_NEAR(found.front, kPi / 2.0 + GetParam().placement.yaw_rad, 0.02);

  for (const sim::NamedLevel& level : person.levels()) {
    const Landmark* landmark = found.landmarks.Find("level." + level.id);
    ASSERT_NE(landmark, nullptr) << level.id;
    const double sigma = std::hypot(body.WithSigma(landmark->z).sigma, landmark->placing_up);
    EXPECT_LT(std::abs(landmark->z.value - level.z_mm), 3.0 * sigma) << level.id;
    if (level.id != "chest") {
      EXPECT_LT(sigma, 2.0) << level.id;
    }
    EXPECT_EQ(landmark->source, LandmarkSource::kDetected);
  }
  const Landmark* axilla = found.landmarks.Find("level.axilla");
  ASSERT_NE(axilla, nullptr);
  EXPECT_LT(std::abs(axilla->z.value - *person.heights().armpit_mm), 3.0 * axilla->placing_up);

  // The bust's bumps: 0.62 rad beside the front of body coordinates, at 1245/1700 of the stature, less a bit for the
  // chest's slope.
  const double scale = GetParam().height_mm / 1700.0;
  for (const char* id : {"bust_right", "bust_left"}) {
    const Landmark* bust = found.landmarks.Find(id);
    ASSERT_NE(bust, nullptr) << id;
    EXPECT_EQ(bust->source, LandmarkSource::kDetected);
    EXPECT_NEAR(bust->z.value, 1245.0 * scale, 6.0) << id;
  }
  // The sides are mirror images of each other but for the noise and the axis's place.
  for (const auto& [right, left] : {std::pair("neck_right", "neck_left"), std::pair("bust_right", "bust_left")}) {
    const Landmark* a = found.landmarks.Find(right);
    const Landmark* b = found.landmarks.Find(left);
    ASSERT_TRUE(a != nullptr && b != nullptr) << right;
    EXPECT_NEAR(a->z.value, b->z.value, 6.0) << right;
    EXPECT_GT(a->position.x(), b->position.x()) << right;
  }
}

INSTANTIATE_TEST_SUITE_P(OfSeveralBuilds, LandmarksOfAPerson,
                         testing::Values(sim::PersonOptions{}, sim::PersonOptions{1480.0, 1.1, {-12.0, 9.0, -0.1}},
                                         sim::PersonOptions{1930.0, 0.88, {10.0, 12.0, 0.08}}));

TEST(LandmarksOfATrunk, HaveNoHeadNoNeckAndNoCrotch) {
  const sim::ParametricBody person = sim::MakePerson({});
  const Found found(person, {790.0, 1330.0}, 3);
  EXPECT_EQ(found.landmarks.Find("level.head"), nullptr);
  EXPECT_EQ(found.landmarks.Find("level.crotch"), nullptr);
  EXPECT_EQ(found.landmarks.Find("neck_front"), nullptr);
  for (const char* id : {"level.waist", "level.hip", "level.iliac", "level.omphalion"}) {
    EXPECT_NE(found.landmarks.Find(id), nullptr) << id;
  }
  EXPECT_THAT(found.landmarks.omitted, testing::Contains(testing::StartsWith("Crotch level: ")));
}

TEST(LandmarksOfAHead, HaveNoTrunk) {
  const sim::ParametricBody head = sim::MakeHead({});
  const Found found(head, {head.bottom_mm() + 20.0, 3000.0, 2.0}, 3);
  EXPECT_NE(found.landmarks.Find("level.head"), nullptr);
  EXPECT_NE(found.landmarks.Find("level.neck"), nullptr);
  EXPECT_NE(found.landmarks.Find("pronasale"), nullptr);
  for (const char* id : {"level.waist", "level.chest", "level.axilla", "bust_left", "shoulder_right"}) {
    EXPECT_EQ(found.landmarks.Find(id), nullptr) << id;
  }
}

}  // namespace
}  // namespace annulus
