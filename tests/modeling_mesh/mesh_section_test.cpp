#include "modeling/mesh/mesh_section.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"

namespace annulus {
namespace {

TEST(MeshSection, OfABoxIsItsRectangle) {
  const TriangleMesh box = test_shapes::Box({-1, -2, -3}, {1, 2, 3});
  for (const double z : {-2.9, 0.0, 1.234}) {
    const auto loops = SliceMesh(box, z);
    ASSERT_EQ(loops.size(), 1U);
    EXPECT_TRUE(loops[0].closed);
    EXPECT_NEAR(loops[0].perimeter_mm, 12.0, 1e-12);
    EXPECT_NEAR(loops[0].area_mm2, 8.0, 1e-12);
  }
  EXPECT_TRUE(SliceMesh(box, 3.1).empty());
  EXPECT_EQ(SliceMesh(box, 3.0).size(), 1U);  // vertices on the plane count as above it
  EXPECT_TRUE(SliceMesh(box, -3.0).empty());
}

TEST(MeshSection, OfASuperellipticColumnHasTheAreaOfTheGammaFunction) {
  // |x/a|⁴ + |y/b|⁴ = 1 holds 4 a b Γ(1 + 1/4)² / Γ(1 + 2/4).
  constexpr std::uint32_t kCount = 4000;
  TriangleMesh column;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double c = std::cos(kTwoPi * i / kCount) / 70.0;
    const double s = std::sin(kTwoPi * i / kCount) / 50.0;
    const double radius = std::pow(c * c * c * c + s * s * s * s, -0.25);
    column.vertices.emplace_back(radius * c * 70.0, radius * s * 50.0, 0.0);
    column.vertices.emplace_back(radius * c * 70.0, radius * s * 50.0, 10.0);
    const std::uint32_t next = 2 * ((i + 1) % kCount);
    column.faces.push_back({2 * i, next, next + 1});
    column.faces.push_back({2 * i, next + 1, 2 * i + 1});
  }
  const auto loops = SliceMesh(column, 3.3);
  ASSERT_EQ(loops.size(), 1U);
  const double area = 4.0 * 70.0 * 50.0 * std::pow(std::tgamma(1.25), 2) / std::tgamma(1.5);
  EXPECT_NEAR(loops[0].area_mm2, area, 2e-6 * area);
}

TEST(MeshSection, OfALyingTorusIsARing) {
  const auto loops = SliceMesh(test_shapes::Torus(20.0, 6.0, 720, 361), 0.0);
  ASSERT_EQ(loops.size(), 2U);
  // The outer circle encloses material, the inner one a hole.
  EXPECT_NEAR(loops[0].area_mm2, kPi * 26.0 * 26.0, 0.3);
  EXPECT_NEAR(loops[1].area_mm2, -kPi * 14.0 * 14.0, 0.3);
  EXPECT_NEAR(loops[0].perimeter_mm, kTwoPi * 26.0, 0.02);
}

TEST(MeshSection, OfAStandingTorusHasTwoLoops) {
  TriangleMesh torus = test_shapes::Torus(20.0, 6.0, 720, 360);
  for (Eigen::Vector3d& v : torus.vertices) v = Eigen::Vector3d(v.x(), -v.z(), v.y());  // a quarter turn about x
  const auto loops = SliceMesh(torus, 0.0);
  ASSERT_EQ(loops.size(), 2U);
  for (const SectionLoop& loop : loops) EXPECT_NEAR(loop.area_mm2, kPi * 36.0, 0.02);
}

TEST(MeshSection, IsOpenWhereTheMeshHasAHole) {
  TriangleMesh box = test_shapes::Box({-1, -1, -1}, {1, 1, 1});
  box.faces.resize(box.faces.size() - 2);  // the side at +x
  const auto loops = SliceMesh(box, 0.1);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_FALSE(loops[0].closed);
  EXPECT_NEAR(loops[0].perimeter_mm, 6.0, 1e-12);
  EXPECT_EQ(loops[0].area_mm2, 0.0);
}

TEST(SlabVolume, OfATorusIsPappus) {
  const TriangleMesh torus = test_shapes::Torus(20.0, 6.0, 720, 360);
  const double whole = 2.0 * kPi * kPi * 20.0 * 36.0;
  EXPECT_NEAR(SlabVolume(torus, -10.0, 10.0), whole, 2e-4 * whole);
  EXPECT_NEAR(SlabVolume(torus, 0.0, 10.0), whole / 2.0, 2e-4 * whole);
  EXPECT_EQ(SlabVolume(torus, 7.0, 10.0), 0.0);
}

TEST(SlabVolume, IsExactForAPyramidOffTheOrigin) {
  TriangleMesh pyramid;  // base 2 x 2 at z = 10, apex 3 above
  pyramid.vertices = {{100, 50, 10}, {102, 50, 10}, {102, 52, 10}, {100, 52, 10}, {100.3, 51.1, 13}};
  pyramid.faces = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  EXPECT_NEAR(SlabVolume(pyramid, 0.0, 20.0), 4.0, 1e-10);
  // Above a third of the height: (2/3)³ of it.
  EXPECT_NEAR(SlabVolume(pyramid, 11.0, 20.0), 4.0 * 8.0 / 27.0, 1e-10);
  EXPECT_NEAR(SlabVolume(pyramid, 11.0, 12.0), 4.0 * 7.0 / 27.0, 1e-10);
}

}  // namespace
}  // namespace annulus
