#include "modeling/table/place_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/modeling_measure/bumpy_body.h"

namespace annulus {
namespace {

Landmark PointAt(const std::string& id, const Estimate& theta, const Estimate& z) {
  Landmark landmark;
  landmark.id = id;
  landmark.theta = theta;
  landmark.z = z;
  return landmark;
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

SurfaceModel Cylinder() {
  return test::InterpolatedBody([](double, double) { return 100.0; }, 90, UniformBreakpoints(0.0, 300.0, 30));
}

TEST(StraightDistance, OfPointsOfACylinderIsTheChordBetweenThem) {
  // A quarter turn on a radius of 100 mm, 100 mm up: √(2·100² + 100²).
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const RawMeasurement raw =
      StraightDistance(body, PointAt("a", {0.0, {}}, {100.0, {}}), PointAt("b", {kPi / 2.0, {}}, {200.0, {}}));
  EXPECT_NEAR(raw.estimate.value, 100.0 * std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(raw.height_share, 100.0 / std::sqrt(3.0), 1e-9);  // dz²/distance
  EXPECT_EQ(raw.height_offset, 0.0);
  EXPECT_EQ(raw.measured_share, 1.0);
  EXPECT_EQ(raw.placing_variance, 0.0);
  ASSERT_EQ(raw.paths.size(), 1U);
  EXPECT_NEAR((raw.paths[0][0] - Eigen::Vector3d(100.0, 0.0, 100.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((raw.paths[0][1] - Eigen::Vector3d(0.0, 100.0, 200.0)).norm(), 0.0, 1e-9);
}

TEST(StraightDistance, TakesPlacingAlongTheSkin) {
  // Points at the ends of a diameter at the heights 100 and 200 mm: sideways placing does not change their distance
  // d = √(200² + 100²), 3 mm up changes it by 3·100/d; at points a quarter turn apart at one height, sideways by 1/√2.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  Landmark a = PointAt("a", {0.0, {}}, {100.0, {}});
  a.placing_across = 4.0;
  a.placing_up = 3.0;
  const RawMeasurement aslant = StraightDistance(body, a, PointAt("b", {kPi, {}}, {200.0, {}}));
  EXPECT_NEAR(std::sqrt(aslant.placing_variance), 300.0 / std::hypot(200.0, 100.0), 1e-9);
  const RawMeasurement level = StraightDistance(body, a, PointAt("b", {kPi / 2.0, {}}, {100.0, {}}));
  EXPECT_NEAR(std::sqrt(level.placing_variance), 4.0 / std::sqrt(2.0), 1e-9);
}

TEST(StraightDistance, OfOnePointTwiceIsNoughtAndFinite) {
  const SurfaceModel model = Cylinder();
  Landmark a = PointAt("a", {1.0, {}}, {100.0, {}});
  a.placing_up = 2.0;
  const RawMeasurement raw = StraightDistance(Measured(model), a, a);
  EXPECT_EQ(raw.estimate.value, 0.0);
  EXPECT_EQ(raw.height_share, 0.0);
  EXPECT_EQ(raw.placing_variance, 0.0);
  EXPECT_EQ(raw.estimate.gradient.norm(), 0.0);
}

TEST(StraightDistance, TellsHowManyOfItsEndsWereSeen) {
  SurfaceModel model = Cylinder();  // 40 rows of 7.5 mm, 36 columns
  model.segments.front().knowledge.SetCell(0, 13, Knowledge::kInferred);
  const MeasuredSurface body = Measured(model);
  const Landmark inferred = PointAt("a", {0.0, {}}, {100.0, {}});
  const Landmark seen = PointAt("b", {2.0, {}}, {200.0, {}});
  EXPECT_EQ(StraightDistance(body, inferred, seen).measured_share, 0.5);
  EXPECT_EQ(SlopeBelowHorizontal(body, seen, inferred).measured_share, 0.5);
}

TEST(SlopeBelowHorizontal, IsPositiveDownwards) {
  // On a cylinder, from the right to the left end of a diameter (200 mm) and 200·tan 20° mm down or up.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const double drop = 200.0 * std::tan(RadiansFromDegrees(20.0));
  const Landmark high = PointAt("a", {0.0, {}}, {150.0 + drop, {}});
  const Landmark low = PointAt("b", {kPi, {}}, {150.0, {}});
  EXPECT_NEAR(SlopeBelowHorizontal(body, high, low).estimate.value, 20.0, 1e-9);
  EXPECT_NEAR(SlopeBelowHorizontal(body, low, high).estimate.value, -20.0, 1e-9);
}

TEST(SlopeBelowHorizontal, FollowsHeightsAndPlacing) {
  // d(angle)/d(height) = cos²/along: by a scale s of heights the angle grows by s·sin·cos.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const double angle = RadiansFromDegrees(20.0);
  Landmark high = PointAt("a", {0.0, {}}, {150.0 + 200.0 * std::tan(angle), {}});
  high.placing_up = 2.0;
  const RawMeasurement raw = SlopeBelowHorizontal(body, high, PointAt("b", {kPi, {}}, {150.0, {}}));
  EXPECT_NEAR(raw.height_share, DegreesFromRadians(std::sin(angle) * std::cos(angle)), 1e-9);
  EXPECT_NEAR(std::sqrt(raw.placing_variance), DegreesFromRadians(2.0 * std::pow(std::cos(angle), 2) / 200.0), 1e-9);
}

TEST(SlopeBelowHorizontal, OfAnUprightLineIsARightAngle) {
  const SurfaceModel model = Cylinder();
  const RawMeasurement raw =
      SlopeBelowHorizontal(Measured(model), PointAt("a", {1.0, {}}, {200.0, {}}), PointAt("b", {1.0, {}}, {100.0, {}}));
  EXPECT_NEAR(raw.estimate.value, 90.0, 1e-9);
  EXPECT_FALSE(std::isnan(raw.placing_variance));
}

TEST(FrameAt, IsThePointAndItsDerivatives) {
  const SurfaceModel model = test::BumpyBody();
  const MeasuredSurface body = Measured(model);
  const PlaceFrame frame = FrameAt(body, {2.2, 131.0});
  constexpr double kStep = 1e-5;
  const auto point = [&](double theta, double z) { return body.surface().Point(theta, z); };
  EXPECT_NEAR((frame.position - point(2.2, 131.0)).norm(), 0.0, 1e-12);
  const Eigen::Vector3d by_theta = (point(2.2 + kStep, 131.0) - point(2.2 - kStep, 131.0)) / (2.0 * kStep);
  const Eigen::Vector3d by_z = (point(2.2, 131.0 + kStep) - point(2.2, 131.0 - kStep)) / (2.0 * kStep);
  EXPECT_NEAR((frame.by_theta - by_theta).norm(), 0.0, 1e-5);
  EXPECT_NEAR((frame.by_z - by_z).norm(), 0.0, 1e-7);
  EXPECT_NEAR((frame.by_radius - Eigen::Vector3d(std::cos(2.2), std::sin(2.2), 0.0)).norm(), 0.0, 1e-12);
}

/// Two landmarks that move with the surface: theta and z follow radii at places of their own.
struct Moving {
  Gradient a_theta;
  Gradient a_z;
  Gradient b_theta;
  Gradient b_z;

  explicit Moving(const SplineSurface& surface) {
    const auto radius = [&](double theta, double z, double weight) {
      GradientSum sum(surface);
      sum.AddRadius(theta, z, weight);
      return sum.Get();
    };
    a_theta = radius(0.3, 80.0, 0.02);
    a_z = radius(0.5, 90.0, -1.5);
    b_theta = radius(2.1, 200.0, -0.03);
    b_z = radius(2.3, 210.0, 2.0);
  }
};

using Between = RawMeasurement (*)(const MeasuredSurface&, const Landmark&, const Landmark&);

void ExpectGradientOf(Between measure) {
  const SurfaceModel model = test::BumpyBody();
  const Moving moving(model.main().surface);
  std::mt19937_64 random(5);
  for (int k = 0; k < 5; ++k) {
    Eigen::VectorXd direction(model.main().surface.coefficients().size());
    for (double& entry : direction) entry = test::Normal(random);
    const auto value = [&](double step) {
      const SurfaceModel moved = test::WithCoefficients(model, model.main().surface.coefficients() + step * direction);
      return measure(Measured(moved),
                     PointAt("a", {0.4 + step * moving.a_theta.dot(direction), {}},
                             {85.0 + step * moving.a_z.dot(direction), {}}),
                     PointAt("b", {2.2 + step * moving.b_theta.dot(direction), {}},
                             {205.0 + step * moving.b_z.dot(direction), {}}))
          .estimate.value;
    };
    constexpr double kStep = 1e-4;  // mm
    const double by_differences = (value(kStep) - value(-kStep)) / (2.0 * kStep);
    const RawMeasurement raw = measure(Measured(model), PointAt("a", {0.4, moving.a_theta}, {85.0, moving.a_z}),
                                       PointAt("b", {2.2, moving.b_theta}, {205.0, moving.b_z}));
    EXPECT_NEAR(raw.estimate.gradient.dot(direction), by_differences, 1e-5 * (1.0 + std::abs(by_differences)));
  }
}

TEST(FollowPoint, GivesStraightDistancesTheGradientThatDifferencesShow) { ExpectGradientOf(StraightDistance); }
TEST(FollowPoint, GivesSlopesTheGradientThatDifferencesShow) { ExpectGradientOf(SlopeBelowHorizontal); }

}  // namespace
}  // namespace annulus
