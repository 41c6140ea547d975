#include "modeling/measure/closest_point.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

const std::vector<double> kBreaks = UniformBreakpoints(0.0, 300.0, 60);

SurfaceModel Cylinder() {
  return InterpolatedBody([](double, double) { return 100.0; }, 36, kBreaks);
}

/// Lobes, waists and a slope.
SurfaceModel Wavy() {
  return InterpolatedBody(
      [](double theta, double z) {
        return 110.0 + 20.0 * std::cos(3.0 * theta) + 12.0 * std::sin(z / 25.0 + theta) - 0.1 * z;
      },
      120, kBreaks);
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

ClosestPoint Nearest(const MeasuredSurface& body, const Eigen::Vector3d& point) {
  const auto nearest = NearestOnSurface(body, point);
  if (!nearest) throw std::runtime_error(nearest.error().Text());
  return *nearest;
}

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

TEST(ClosestPoint, OfACylinderIsOnTheSameRay) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  for (const double radius : {5.0, 60.0, 99.0, 101.0, 140.0, 5000.0}) {
    const ClosestPoint nearest = Nearest(body, PointFromCylindrical(5.5, radius, 123.0));
    EXPECT_NEAR(nearest.place.theta, 5.5, 1e-8);
    EXPECT_NEAR(nearest.place.z, 123.0, 1e-7);
    EXPECT_NEAR(nearest.signed_distance.value, radius - 100.0, 1e-9);
    EXPECT_EQ(nearest.kind, NearestPlace::kWithin);
    EXPECT_EQ(nearest.knowledge, Knowledge::kMeasured);
    // A body that grows by 1 mm comes 1 mm nearer to what is outside.
    EXPECT_NEAR(nearest.signed_distance.gradient.sum(), -1.0, 1e-9);
  }
}

TEST(ClosestPoint, OfASphereIsTowardsItsCentre) {
  const double radius = 200.0;
  const SurfaceModel model =
      InterpolatedBody([&](double, double z) { return std::sqrt(radius * radius - (z - 150.0) * (z - 150.0)); }, 72,
                       UniformBreakpoints(0.0, 300.0, 300));
  const MeasuredSurface body = Measured(model);
  for (const Eigen::Vector3d& offset :
       {Eigen::Vector3d(30.0, -20.0, 5.0), Eigen::Vector3d(-250.0, 100.0, 90.0), Eigen::Vector3d(0.5, 0.5, 0.1)}) {
    const ClosestPoint nearest = Nearest(body, Eigen::Vector3d(0.0, 0.0, 150.0) + offset);
    EXPECT_NEAR(nearest.signed_distance.value, offset.norm() - radius, 1e-6);
    // Nearer the centre the foot of the perpendicular follows the smallest bump.
    EXPECT_LT((nearest.position - Eigen::Vector3d(0.0, 0.0, 150.0) - radius * offset.normalized()).norm(),
              5e-5 * radius / offset.norm());
  }
}

TEST(ClosestPoint, IsTheFootOfEveryPerpendicularShorterThanTheBendAllows) {
  // From a place on the surface out along the normal, or in by less than its narrowest radius of curvature (the crests
  // of r = 110 + 20 cos 3θ … have about 45 mm, the waves along z 25²/12 = 52 mm; outward valleys have 52 mm too).
  const SurfaceModel model = Wavy();
  const MeasuredSurface body = Measured(model);
  std::mt19937_64 random(4);
  for (int k = 0; k < 60; ++k) {
    const SurfacePlace place{Uniform(random, 0.0, kTwoPi), Uniform(random, 40.0, 260.0)};
    const double distance = Uniform(random, -20.0, 20.0);
    const Eigen::Vector3d normal = body.Normal(place.theta, place.z);
    const ClosestPoint nearest = Nearest(body, body.Point(place.theta, place.z) + distance * normal);
    EXPECT_NEAR(AngleDifference(nearest.place.theta, place.theta), 0.0, 1e-6);
    EXPECT_NEAR(nearest.place.z, place.z, 1e-4);
    EXPECT_NEAR(nearest.signed_distance.value, distance, 1e-8);
    const double by_radius = normal.dot(Eigen::Vector3d(std::cos(place.theta), std::sin(place.theta), 0.0));
    EXPECT_NEAR(nearest.signed_distance.gradient.sum(), -by_radius, 1e-5);
  }
}

TEST(ClosestPoint, IsNotFartherThanAnyPointOfADenseGrid) {
  const SurfaceModel model = Wavy();
  const MeasuredSurface body = Measured(model);
  std::vector<Eigen::Vector3d> grid;
  for (int i = 0; i < 720; ++i) {
    for (int j = 0; j <= 300; ++j) grid.push_back(body.Point(kTwoPi * i / 720.0, j));
  }
  std::mt19937_64 random(5);
  for (int k = 0; k < 60; ++k) {
    // About the axis and above, below and beside the body, where several places are nearly as near.
    const Eigen::Vector3d point(Uniform(random, -150.0, 150.0), Uniform(random, -150.0, 150.0),
                                Uniform(random, -60.0, 360.0));
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : grid) least = std::min(least, (p - point).norm());
    const double found = std::abs(Nearest(body, point).signed_distance.value);
    EXPECT_LE(found, least + 1e-9);
    EXPECT_GE(found, least - 0.7);  // half the diagonal of the grid's cells
  }
}

TEST(ClosestPoint, BeyondAnEndIsOnTheRim) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const ClosestPoint above = Nearest(body, PointFromCylindrical(1.0, 60.0, 330.0));
  EXPECT_EQ(above.kind, NearestPlace::kAtEnd);
  EXPECT_EQ(above.place.z, 300.0);
  EXPECT_NEAR(above.place.theta, 1.0, 1e-9);
  EXPECT_NEAR(above.signed_distance.value, 50.0, 1e-9);  // √(40² + 30²), open above: outside
  // d/dr of √((60 - r)² + 30²) at r = 100 is 40/50.
  EXPECT_NEAR(above.signed_distance.gradient.sum(), 0.8, 1e-9);
  EXPECT_NEAR(Nearest(body, PointFromCylindrical(1.0, 130.0, -40.0)).signed_distance.value, 50.0, 1e-9);
}

TEST(ClosestPoint, OfAPointOnTheSurfaceIsThatPoint) {
  const SurfaceModel model = Wavy();
  const MeasuredSurface body = Measured(model);
  const ClosestPoint nearest = Nearest(body, body.Point(2.0, 111.0));
  EXPECT_NEAR(nearest.signed_distance.value, 0.0, 1e-9);
  EXPECT_NEAR(nearest.place.theta, 2.0, 1e-9);
  const Eigen::Vector3d ray(std::cos(2.0), std::sin(2.0), 0.0);
  EXPECT_NEAR(nearest.signed_distance.gradient.sum(), -body.Normal(2.0, 111.0).dot(ray), 1e-6);
}

TEST(ClosestPoint, OfManyIsTheLowestAndThenTheFirstAround) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const ClosestPoint axis = Nearest(body, {0.0, 0.0, 150.0});
  EXPECT_EQ(axis.place.theta, 0.0);
  EXPECT_NEAR(axis.place.z, 150.0, 1e-6);
  EXPECT_NEAR(axis.signed_distance.value, -100.0, 1e-9);
  // Halfway between two equal bulges at z = 100 and 200: the lower one.
  const SurfaceModel bulges =
      InterpolatedBody([](double, double z) { return 100.0 - 20.0 * std::cos(kTwoPi * (z - 50.0) / 100.0); }, 36,
                       UniformBreakpoints(0.0, 300.0, 300));
  const ClosestPoint lower = Nearest(Measured(bulges), {260.0, 0.0, 150.0});
  EXPECT_LT(lower.place.z, 150.0);
  EXPECT_GT(lower.place.z, 50.0);
}

TEST(ClosestPoint, IsRefusedForWhatIsNoPlaceAndWhereNothingWasSeen) {
  SurfaceModel model = Cylinder();
  KnowledgeMap& map = model.segments.front().knowledge;
  for (std::size_t row = 0; row < map.rows(); ++row) map.SetCell(9, row, Knowledge::kUnknown);
  const MeasuredSurface body = Measured(model);
  const auto seen = [&](const Eigen::Vector3d& point) {
    const auto nearest = NearestOnSurface(body, point);
    return nearest ? std::string("found") : nearest.error().Text();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(seen({nan, 0.0, 0.0}), HasSubstr("not finite"));
  EXPECT_THAT(seen({0.0, 0.0, std::numeric_limits<double>::infinity()}), HasSubstr("not finite"));
  EXPECT_THAT(seen({0.0, 1e7, 0.0}), HasSubstr("too far"));
  EXPECT_THAT(seen({0.0, 130.0, 150.0}), HasSubstr("theta = 90 deg, z = 150 mm was not seen"));
  EXPECT_EQ(seen({130.0, 0.0, 150.0}), "found");
}

}  // namespace
}  // namespace annulus
