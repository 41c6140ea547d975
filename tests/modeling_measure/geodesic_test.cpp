#include "modeling/measure/geodesic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/modeling_measure/bumpy_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;

double Length(const Result<SurfaceDistance>& distance) {
  if (!distance) throw std::runtime_error(distance.error().Text());
  return distance->length.value;
}

std::vector<double> Breaks() { return UniformBreakpoints(-100.0, 200.0, 150); }

TEST(Geodesic, OnACylinderIsStraightOnTheUnrolledSheetAlsoOverTheSeam) {
  const SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  for (const auto& [from, to] : {std::pair<SurfacePlace, SurfacePlace>{{0.3, -50.0}, {2.0, 100.0}},
                                 {{6.0, -50.0}, {1.0, 150.0}},
                                 {{0.1, 20.0}, {-0.2, -20.0}},
                                 {{1.0, 0.0}, {1.02, 1.0}},
                                 {{1.0, -100.0}, {4.0, -100.0}},
                                 {{2.0, -100.0}, {2.0, 200.0}}}) {
    const double expected = std::hypot(90.0 * AngleDifference(to.theta, from.theta), to.z - from.z);
    EXPECT_NEAR(Length(GeodesicDistance(*body, from, to)), expected, 1e-7 * expected);
  }
}

TEST(Geodesic, OnAConeIsStraightOnTheUnrolledSheet) {
  // r = 150 - 0.375 z: distance from the apex s = r / sin(a), angle on the sheet theta·sin(a), tan(a) = 0.375.
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 150.0 - 0.375 * z; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  const double sine = 0.375 / std::hypot(1.0, 0.375);
  for (const auto& [from, to] : {std::pair<SurfacePlace, SurfacePlace>{{0.3, -50.0}, {2.0, 100.0}},
                                 {{6.0, -50.0}, {1.0, 150.0}},
                                 {{0.0, 0.0}, {3.1, 0.0}}}) {
    const double a = (150.0 - 0.375 * from.z) / sine;
    const double b = (150.0 - 0.375 * to.z) / sine;
    const double angle = AngleDifference(to.theta, from.theta) * sine;
    const double expected = std::sqrt(a * a + b * b - 2.0 * a * b * std::cos(angle));
    EXPECT_NEAR(Length(GeodesicDistance(*body, from, to)), expected, 1e-7 * expected);
  }
}

TEST(Geodesic, OnAnEllipsoidIsTheMeridian) {
  // import numpy as np; from scipy.integrate import quad; a, c = 80, 120
  // quad(lambda z: np.hypot(1, a*z/(c*c*np.sqrt(1-z*z/(c*c)))), -70, 80, epsabs=1e-12)[0]
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 80.0 * std::sqrt(1.0 - z * z / 14400.0); },
                                              12, UniformBreakpoints(-100.0, 100.0, 200));
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_NEAR(Length(GeodesicDistance(*body, {0.0, -70.0}, {0.0, 80.0})), 155.7009510488899, 1.6e-4);
}

TEST(Geodesic, OnASphereIsTheGreatCircleAlsoNearlyToTheOtherSide) {
  const SurfaceModel model = InterpolatedBody([](double, double z) { return std::sqrt(1e4 - z * z); }, 12,
                                              UniformBreakpoints(-80.0, 80.0, 160));
  const auto body = MeasuredSurface::FromModel(model);
  for (const auto& [from, to] : {std::pair<SurfacePlace, SurfacePlace>{{0.3, -50.0}, {2.0, 60.0}},
                                 {{6.0, -50.0}, {1.0, 10.0}},
                                 {{0.3, -30.0}, {0.3 + 3.0, 32.0}}}) {
    const Eigen::Vector3d a = PointFromCylindrical(from.theta, std::sqrt(1e4 - from.z * from.z), from.z);
    const Eigen::Vector3d b = PointFromCylindrical(to.theta, std::sqrt(1e4 - to.z * to.z), to.z);
    const double expected = 100.0 * std::acos(a.dot(b) / 1e4);
    EXPECT_NEAR(Length(GeodesicDistance(*body, from, to)), expected, 1e-6 * expected);
  }
}

TEST(Geodesic, RunsAlongTheRimWhereItWouldLeaveTheRange) {
  // A sphere seen up to latitude q: great circles from latitude p touch that parallel after an arc of
  // acos(sin p / sin q) and a turn of acos(tan p / tan q); between, the path is the parallel.
  const SurfaceModel model = InterpolatedBody([](double, double z) { return std::sqrt(1e4 - z * z); }, 12,
                                              UniformBreakpoints(-40.0, 40.0, 160));
  const auto body = MeasuredSurface::FromModel(model);
  const double p = std::asin(0.35);
  const double q = std::asin(0.4);
  const double turn = 2.2;
  const double along = 100.0 * std::cos(q) * (turn - 2.0 * std::acos(std::tan(p) / std::tan(q)));
  const double expected = 200.0 * std::acos(0.35 / 0.4) + along;
  const auto path = GeodesicDistance(*body, {5.0, 35.0}, {5.0 + turn, 35.0});
  EXPECT_NEAR(Length(path), expected, 1e-6 * expected);
  EXPECT_NEAR(RimShare(body->surface(), path->path), along / expected, 0.03);
  EXPECT_EQ(RimShare(body->surface(), GeodesicDistance(*body, {5.0, 0.0}, {5.4, 0.0})->path), 0.0);
}

TEST(Geodesic, GoesAroundABumpAndNotOverIt) {
  // A hill of 60 mm on a cylinder of radius 100 in the way of the straight line: around it is at most as long as the
  // broken line that passes beside it; over it would be 2·60 mm longer.
  const auto hill = [](double theta, double z) {
    const double square = std::pow(100.0 * AngleDifference(theta, 1.0) / 12.0, 2) + std::pow((z - 53.0) / 12.0, 2);
    return 100.0 + 60.0 * std::exp(-square);
  };
  const SurfaceModel model = InterpolatedBody(hill, 180, UniformBreakpoints(-100.0, 200.0, 150));
  const auto body = MeasuredSurface::FromModel(model);
  const double length = Length(GeodesicDistance(*body, {0.0, 50.0}, {2.0, 50.0}));
  EXPECT_GT(length, 200.0);
  EXPECT_LT(length, 2.0 * std::hypot(100.0, 35.0));
}

TEST(Geodesic, IsAMetric) {
  const SurfaceModel model = test::BumpyBody();
  const auto body = MeasuredSurface::FromModel(model);
  std::mt19937_64 random(7);
  for (int k = 0; k < 25; ++k) {
    const SurfacePlace a = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace b = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace c = test::RandomPlace(random, 20.0, 280.0);
    const auto forth = GeodesicDistance(*body, a, b);
    const auto back = GeodesicDistance(*body, b, a);
    EXPECT_EQ(Length(forth), Length(back));
    EXPECT_LT((forth->path.front().position - back->path.back().position).norm(), 1e-9);
    EXPECT_LT((forth->path.front().position - body->surface().Point(a.theta, a.z)).norm(), 1e-9);
    EXPECT_GE(Length(forth), (body->surface().Point(a.theta, a.z) - body->surface().Point(b.theta, b.z)).norm() - 1e-9);
    EXPECT_LE(Length(forth), Length(GeodesicDistance(*body, a, c)) + Length(GeodesicDistance(*body, c, b)) + 1e-6);
  }
}

TEST(Geodesic, FollowsTheSurfaceAsItsGradientSays) {
  const SurfaceModel model = test::BumpyBody();
  std::mt19937_64 random(8);
  for (std::uint64_t k = 0; k < 4; ++k) {
    const SurfacePlace a = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace b = test::RandomPlace(random, 20.0, 280.0);
    const auto derivatives = test::DerivativesOf(
        model, [&](const MeasuredSurface& body) { return GeodesicDistance(body, a, b); }, k);
    EXPECT_NEAR(derivatives.by_gradient, derivatives.by_differences, 1e-3) << k;
  }
}

TEST(Geodesic, OnANoisySurfaceIsLongerThanOnTheSmoothOneByItsRippleOnly) {
  // Independent coefficients of sd 0.3 mm on 2 mm knots: slopes of some 0.1, hence paths longer by at most 2 %.
  const SurfaceModel smooth = InterpolatedBody([](double, double) { return 90.0; }, 180, Breaks());
  std::mt19937_64 random(9);
  Eigen::VectorXd c = smooth.main().surface.coefficients();
  for (double& value : c) value += 0.3 * test::Normal(random);
  const SurfaceModel noisy = test::WithCoefficients(smooth, c);
  const auto body = MeasuredSurface::FromModel(noisy);
  const double straight = std::hypot(90.0 * 2.0, 150.0);
  const double length = Length(GeodesicDistance(*body, {0.0, -50.0}, {2.0, 100.0}));
  EXPECT_NEAR(length, straight, 0.02 * straight);
}

TEST(Geodesic, BetweenCoincidentPlacesIsZero) {
  const SurfaceModel model = test::BumpyBody();
  const auto body = MeasuredSurface::FromModel(model);
  const auto none = GeodesicDistance(*body, {1.0, 50.0}, {1.0 + kTwoPi, 50.0});
  EXPECT_EQ(Length(none), 0.0);
  EXPECT_EQ(none->path.size(), 2U);
  EXPECT_EQ(none->knowledge.measured, 1.0);
  EXPECT_NEAR(Length(GeodesicDistance(*body, {1.0, 50.0}, {1.0 + 1e-7, 50.0})), 1e-5, 1e-5);
}

TEST(Geodesic, FailsOutsideTheRangeAndOverWhatWasNotSeenAndCountsWhatWasInferred) {
  SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 250.0}) {
    EXPECT_FALSE(GeodesicDistance(*body, {1.0, bad}, {2.0, 0.0}).has_value());
  }
  EXPECT_FALSE(GeodesicDistance(*body, {1.0, 0.0}, {std::nan(""), 0.0}).has_value());
  const auto outside = GeodesicDistance(*body, {1.0, 0.0}, {2.0, 250.0});
  ASSERT_FALSE(outside.has_value());
  EXPECT_THAT(outside.error().Text(), testing::HasSubstr("from -100 to 200 mm"));
  // Column 9 is centred on 90 degrees and 10 degrees wide: 10 of the 40 degrees of the path.
  for (std::size_t row = 0; row < 40; ++row) model.segments.front().knowledge.SetCell(9, row, Knowledge::kInferred);
  const SurfacePlace left{RadiansFromDegrees(70.0), 50.0};
  const SurfacePlace right{RadiansFromDegrees(110.0), 50.0};
  EXPECT_NEAR(GeodesicDistance(*body, left, right)->knowledge.measured, 0.75, 0.04);
  for (std::size_t row = 0; row < 40; ++row) model.segments.front().knowledge.SetCell(9, row, Knowledge::kUnknown);
  const auto unseen = GeodesicDistance(*body, left, right);
  ASSERT_FALSE(unseen.has_value());
  EXPECT_THAT(unseen.error().Text(), testing::ContainsRegex("2[0-9.]+ % of it was not seen"));
}

}  // namespace
}  // namespace annulus
