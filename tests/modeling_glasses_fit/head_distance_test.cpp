#include "modeling/glasses/head_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/frames.h"
#include "modeling/measure/closest_point.h"
#include "sim/random_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

SplineSurface Cylinder(double radius) {
  const PeriodicCubicBasis theta(90);
  const ClampedCubicBasis z(UniformBreakpoints(1400, 1700, 30));
  const auto count = static_cast<Eigen::Index>(theta.count() * z.count());
  return SplineSurface(theta, z, Eigen::VectorXd::Constant(count, radius));
}

TEST(HeadDistance, IsExactOnACylinder) {
  const SplineSurface surface = Cylinder(80.0);
  const HeadDistance distance(surface, 1450, 1650);
  for (const double radius : {70.0, 79.9, 80.0, 80.2, 95.0, 130.0}) {
    const Vector3d p = PointFromCylindrical(1.3, radius, 1543.2);
    EXPECT_NEAR(distance.Nearest(p).distance, radius - 80.0, 1e-9);
    EXPECT_NEAR(distance.FirstOrder(p).distance, radius - 80.0, 1e-9);
    EXPECT_LT((distance.FirstOrder(p).gradient - PointFromCylindrical(1.3, 1.0, 0.0)).norm(), 1e-9);
  }
}

TEST(HeadDistance, NothingIsInTheWayAboveAndBelow) {
  const SplineSurface surface = Cylinder(80.0);
  const HeadDistance distance(surface, 1450, 1650);
  EXPECT_GT(distance.FirstOrder({10, 10, 1750}).distance, 100.0);
  EXPECT_GT(distance.Nearest({10, 10, 1705}).distance, 0.0);
}

TEST(HeadDistance, AgreesWithTheSearchOverAllPatchesOnAHead) {
  // NearestOnSurface looks at every patch that could hold a nearer place.
  const sim::ParametricBody body = sim::MakeRandomHead(7);
  const SurfaceModel model = test::HeadSurface(body);
  const auto measured = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(measured);
  const double eyes = body.face().right_eye.z();
  const HeadDistance distance(measured->surface(), eyes - 90.0, eyes + 80.0);
  std::mt19937_64 random(20260201);
  std::uniform_real_distribution<double> angle(RadiansFromDegrees(-20.0), RadiansFromDegrees(200.0));
  std::uniform_real_distribution<double> height(eyes - 60.0, eyes + 40.0);
  std::uniform_real_distribution<double> off(-3.0, 20.0);
  for (int k = 0; k < 60; ++k) {
    const double theta = angle(random);
    const double z = height(random);
    const Vector3d p = measured->surface().Point(theta, z) + off(random) * measured->surface().Normal(theta, z);
    const auto nearest = NearestOnSurface(*measured, p);
    ASSERT_TRUE(nearest);
    EXPECT_NEAR(distance.Nearest(p).distance, nearest->signed_distance.value, 1e-3) << k;
  }
}

TEST(HeadDistance, TheGradientIsThatOfTheDistance) {
  const sim::ParametricBody body = sim::MakeRandomHead(8);
  const SurfaceModel model = test::HeadSurface(body);
  const SplineSurface& surface = model.main().surface;
  const double eyes = body.face().right_eye.z();
  const HeadDistance distance(surface, eyes - 90.0, eyes + 80.0);
  for (double theta = 0.2; theta < 3.0; theta += 0.3) {
    // At the skin the first-order distance and the true one have the same slope: the unit normal.
    const Vector3d p = surface.Point(theta, eyes - 10.0);
    const HeadGap gap = distance.FirstOrder(p);
    EXPECT_NEAR(gap.distance, 0.0, 1e-9);
    EXPECT_LT((gap.gradient - surface.Normal(theta, eyes - 10.0)).norm(), 1e-9);
    EXPECT_NEAR(distance.Nearest(p + 0.4 * gap.gradient).distance, 0.4, 0.01);
  }
}

}  // namespace
}  // namespace annulus
