#include "modeling/flatten/surface_region.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "modeling/flatten/flat_element.h"
#include "modeling/flatten/flatten.h"
#include "modeling/flatten/geodesic_side.h"
#include "tests/modeling_flatten/flat_bodies.h"

namespace annulus {
namespace {

constexpr double kPi = std::numbers::pi;

/// A rectangle of places, `steps` to a side.
RegionLines Window(double theta_low, double theta_high, double z_low, double z_high, int steps) {
  RegionLines lines;
  const std::array<Eigen::Vector2d, 4> corner{Eigen::Vector2d(theta_low, z_low), Eigen::Vector2d(theta_high, z_low),
                                              Eigen::Vector2d(theta_high, z_high), Eigen::Vector2d(theta_low, z_high)};
  for (std::size_t k = 0; k < 4; ++k) {
    for (int step = 0; step < steps; ++step) {
      lines.points.emplace_back(corner[k] + (corner[(k + 1) % 4] - corner[k]) * step / steps);
    }
  }
  lines.rim_count = lines.points.size();
  return lines;
}

double LargestStrain(const FlatShape& shape) {
  double largest = 0.0;
  for (const Eigen::Vector3d& strain : shape.strains) {
    largest = std::max(largest, PrincipalStrains(strain).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(GeodesicSide, OfACylinderIsAHelix) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  EXPECT_NEAR(GeodesicSide(cylinder, {0.3, 50.0}, {0.4, 62.0}), std::hypot(10.0, 12.0), 1e-10);
}

TEST(GeodesicSide, OfAConeIsTheChordOfItsDevelopment) {
  // r = 150 − z/2: slant s = r·√5 from the tip (dr = −dz/2, ds = √(dr² + dz²) = √5 |dr|), opening angle scaled by 1/√5.
  const SurfaceSegment cone = test::BodyOf(0.0, 200.0, [](double, double z) { return 150.0 - 0.5 * z; });
  const double root = std::sqrt(5.0);
  const auto developed = [&](double theta, double z) {
    const double slant = root * (150.0 - 0.5 * z);
    return Eigen::Vector2d(slant * std::cos(theta / root), slant * std::sin(theta / root));
  };
  const double length = GeodesicSide(cone, {0.2, 40.0}, {0.28, 48.0});
  EXPECT_NEAR(length, (developed(0.28, 48.0) - developed(0.2, 40.0)).norm(), 1e-9 * length);
}

TEST(FillRegion, OfACylinderAndAConeLiesFlatWithoutStrain) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  const SurfaceSegment cone = test::BodyOf(0.0, 300.0, [](double, double z) { return 150.0 - 0.3 * z; });
  for (const SurfaceSegment* body : {&cylinder, &cone}) {
    const auto region = FillRegion(*body, Window(0.2, 1.9, 40.0, 200.0, 18), 10.0);
    ASSERT_TRUE(region) << region.error().Text();
    const auto shape = Flatten(region->sheet, {});
    ASSERT_TRUE(shape) << shape.error().Text();
    EXPECT_TRUE(shape->converged);
    EXPECT_LE(LargestStrain(*shape), 1e-8);
    EXPECT_EQ(shape->rim_crossings, 0U);
  }
}

TEST(FillRegion, CoversTheRegionWithElementsOfTheSize) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  const RegionLines lines = Window(0.0, 1.0, 50.0, 150.0, 20);
  const auto region = FillRegion(cylinder, lines, 8.0);
  ASSERT_TRUE(region) << region.error().Text();
  EXPECT_NEAR(SheetArea(region->sheet), 100.0 * 1.0 * 100.0, 1e-6);
  for (std::size_t k = 0; k < lines.points.size(); ++k) EXPECT_EQ(region->theta_z[k], lines.points[k]);
  for (const auto& face : region->sheet.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE((region->sheet.places[face[k]] - region->sheet.places[face[(k + 1) % 3]]).norm(), 8.0 + 1e-9);
    }
  }
}

TEST(FillRegion, RefusesLinesThatCrossOrLeaveTheSurface) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  RegionLines bow;
  bow.points = {{0.0, 50.0}, {1.0, 150.0}, {1.0, 50.0}, {0.0, 160.0}};
  bow.rim_count = 4;
  EXPECT_FALSE(FillRegion(cylinder, bow, 10.0));
  EXPECT_FALSE(FillRegion(cylinder, Window(0.0, 1.0, 250.0, 350.0, 10), 10.0));
}

}  // namespace
}  // namespace annulus
