#include "modeling/measure/paper_region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

using Triangle = std::array<Eigen::Vector3d, 3>;

SurfaceModel Cylinder() {
  return InterpolatedBody([](double, double) { return 90.0; }, 12, UniformBreakpoints(0.0, 200.0, 10));
}

SurfaceModel Bumpy() {
  return InterpolatedBody(
      [](double t, double z) {
        return 100.0 + 12.0 * std::cos(2.0 * t + 0.02 * z) + 4.0 * std::sin(5.0 * t) * std::cos(0.07 * z);
      },
      36, UniformBreakpoints(0.0, 200.0, 25));
}

TEST(PaperPrism, HasTheAreaAndVolumeOfItsTriangle) {
  // Right triangle with legs 3 and 4, 5 and 7 above the plane z = 0 at its ends: area 6·(slope), mean height 17/3.
  const Triangle triangle{{{0.0, 0.0, 5.0}, {3.0, 0.0, 5.0}, {0.0, 4.0, 7.0}}};
  EXPECT_NEAR(TriangleArea(triangle), 0.5 * 3.0 * std::hypot(4.0, 2.0), 1e-12);
  const CuttingPlane floor{Eigen::Vector3d::UnitZ(), 0.0};
  EXPECT_NEAR(PrismVolume(triangle, -Eigen::Vector3d::UnitZ(), floor), 6.0 * 17.0 / 3.0, 1e-12);
  // Sheared along the floor, a prism of level top keeps its volume; below the floor or turned over, one counts
  // negative.
  const Triangle level{{{0.0, 0.0, 5.0}, {3.0, 0.0, 5.0}, {0.0, 4.0, 5.0}}};
  EXPECT_NEAR(PrismVolume(level, Eigen::Vector3d(0.6, -0.3, -1.0).normalized(), floor), 30.0, 1e-12);
  EXPECT_NEAR(PrismVolume({triangle[0], triangle[2], triangle[1]}, -Eigen::Vector3d::UnitZ(), floor), -34.0, 1e-12);
  EXPECT_NEAR(PrismVolume(triangle, -Eigen::Vector3d::UnitZ(), {Eigen::Vector3d::UnitZ(), 10.0}),
              6.0 * (17.0 / 3.0 - 10.0), 1e-12);
}

TEST(PaperPrism, IsProjectedAlongPlane2OntoPlane1) {
  const Eigen::Vector3d n1 = Eigen::Vector3d(0.2, 1.0, -0.4);
  const Eigen::Vector3d n2 = Eigen::Vector3d(-0.7, 0.3, 0.9);
  const Eigen::Vector3d v = ProjectionDirection(n1, n2);
  EXPECT_NEAR(v.norm(), 1.0, 1e-14);
  EXPECT_NEAR(v.dot(n1.cross(n2)), 0.0, 1e-14);
  EXPECT_NEAR(v.dot(n2), 0.0, 1e-14);
  EXPECT_LT(v.dot(n1), 0.0);
}

TEST(PaperRegion, OfAFinelyMeshedCylinderIsTheWedge) {
  // Planes z = 100 ± k (x - 90 cos alpha), as in Region: skin 4 k 90² (s - alpha c), volume 2 k 90³ (2 s³/3 - c (alpha
  // - s c)) with s, c = sin, cos alpha.
  const SurfaceModel model = Cylinder();
  const auto body = MeasuredSurface::FromModel(model);
  const double alpha = 1.0;
  const double k = 0.6;
  const auto on = [&](double theta, double slope) {
    return SurfacePlace{theta, 100.0 + slope * 90.0 * (std::cos(theta) - std::cos(alpha))};
  };
  const auto region = RegionOnLattice(*body, {on(-alpha, 0.0), on(alpha, 0.0), on(0.1, k), on(-0.3, -k)}, {1440, 1001});
  ASSERT_TRUE(region.has_value()) << region.error().Text();
  const double s = std::sin(alpha);
  const double c = std::cos(alpha);
  const double skin = 4.0 * k * 8100.0 * (s - alpha * c);
  const double volume = 2.0 * k * 729000.0 * (2.0 / 3.0 * s * s * s - c * (alpha - s * c));
  EXPECT_NEAR(region->area, skin, 2e-4 * skin);
  EXPECT_NEAR(region->volume, volume, 2e-4 * volume);
}

TEST(PaperRegion, ConvergesToTheSplinesWithTheSquareOfTheMesh) {
  const SurfaceModel model = Bumpy();
  const auto body = MeasuredSurface::FromModel(model);
  const RegionClicks clicks{{0.3, 95.0}, {1.5, 105.0}, {0.8, 112.0}, {1.1, 92.0}};
  const auto exact = RegionBetween(*body, clicks);
  ASSERT_TRUE(exact.has_value()) << exact.error().Text();
  std::vector<double> area;
  std::vector<double> volume;
  for (const std::size_t n : {180, 360, 720, 1440}) {
    const auto region = RegionOnLattice(*body, clicks, {n, n + 1});
    ASSERT_TRUE(region.has_value()) << region.error().Text();
    area.push_back(std::abs(region->area - exact->area.value) / exact->area.value);
    volume.push_back(std::abs(region->volume - exact->volume.value) / exact->volume.value);
  }
  EXPECT_LT(area[0], 0.02);
  EXPECT_LT(volume[0], 0.02);
  EXPECT_LT(area[3], 0.1 * area[0] + 1e-5);
  EXPECT_LT(volume[3], 0.1 * volume[0] + 1e-5);
  EXPECT_LT(area[3], 3e-4);
  EXPECT_LT(volume[3], 3e-4);
}

TEST(PaperRegion, IsTheSameInWhateverOrderItIsClicked) {
  const SurfaceModel model = Bumpy();
  const auto body = MeasuredSurface::FromModel(model);
  const SurfacePlace a{0.3, 95.0};
  const SurfacePlace b{1.5, 105.0};
  const SurfacePlace c{0.8, 112.0};
  const SurfacePlace d{1.1, 92.0};
  const auto first = RegionOnLattice(*body, {a, b, c, d}, {360, 401});
  ASSERT_TRUE(first.has_value());
  for (const RegionClicks& other : {RegionClicks{b, a, c, d}, RegionClicks{a, b, d, c}, RegionClicks{b, a, d, c}}) {
    const auto region = RegionOnLattice(*body, other, {360, 401});
    ASSERT_TRUE(region.has_value());
    EXPECT_NEAR(region->area, first->area, 1e-9 * first->area);
    EXPECT_NEAR(region->volume, first->volume, 1e-3 * first->volume);  // fans are cut the other way
  }
}

TEST(PaperRegion, LiesAcrossThetaZeroToo) {
  const SurfaceModel model = Cylinder();
  const auto body = MeasuredSurface::FromModel(model);
  const RegionClicks here{{1.0, 95.0}, {2.0, 105.0}, {1.5, 130.0}, {1.5, 80.0}};
  const RegionClicks there{{kTwoPi - 0.5, 95.0}, {0.5, 105.0}, {0.0, 130.0}, {kTwoPi, 80.0}};
  const auto one = RegionOnLattice(*body, here, {3600, 801});
  const auto other = RegionOnLattice(*body, there, {3600, 801});
  ASSERT_TRUE(one && other);
  EXPECT_NEAR(other->area, one->area, 1e-4 * one->area);
  EXPECT_NEAR(other->volume, one->volume, 1e-3 * one->volume);
}

TEST(PaperRegion, TellsWhatIsWrong) {
  const SurfaceModel model = Cylinder();
  const auto body = MeasuredSurface::FromModel(model);
  const auto says = [&](const RegionClicks& clicks) {
    const auto region = RegionOnLattice(*body, clicks, {180, 41});
    return region ? std::string("nothing") : region.error().Text();
  };
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.4, 50.0}, {0.6, 50.0}}), HasSubstr("A, B, C and D lie in one plane"));
  EXPECT_THAT(says({{0.0, 50.0}, {0.0, 50.0}, {0.4, 90.0}, {0.6, 20.0}}), HasSubstr("A and B are the same point"));
  EXPECT_THAT(says({{0.0, 50.0}, {0.001, 50.1}, {0.0005, 50.2}, {0.0005, 49.9}}), HasSubstr("one mesh"));
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.5, 60.0}, {3.5, 60.0}}), HasSubstr("around the body"));
}

}  // namespace
}  // namespace annulus
