#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/bezier/patch_shell.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

BezierPatch RandomPatch(std::mt19937_64& random) {
  BezierPatch::ControlNet net;
  for (auto& row : net) {
    for (Vector3d& q : row) q = {Uniform(random, -20, 20), Uniform(random, -20, 20), Uniform(random, -20, 20)};
  }
  return BezierPatch(net);
}

/// x = u, y = v, z = u³v³: linear precision in x and y, and B_33(u)·B_33(v) alone in z.
BezierPatch CubicGraph() {
  BezierPatch::ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      net[i][j] = {static_cast<double>(i) / 3.0, static_cast<double>(j) / 3.0, i == 3 && j == 3 ? 1.0 : 0.0};
    }
  }
  return BezierPatch(net);
}

/// A straight tube along x: 6 wide (z), control polygon 4 deep (y).
BezierTube StraightTube() {
  BezierTube::Sections sections;
  for (std::size_t i = 0; i < 4; ++i) {
    sections[i] = {Vector3d(-10.0 * static_cast<double>(i), 0, 0), Vector3d(0, 0, 3), Vector3d(0, 2, 0)};
  }
  return BezierTube(sections);
}

TEST(BezierPatch, BernsteinAndMatrixFormsAgree) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 100; ++k) {
    const BezierPatch patch = RandomPatch(random);
    const double u = Uniform(random, 0, 1);
    const double v = Uniform(random, 0, 1);
    EXPECT_LT((patch.Point(u, v) - patch.PointByMatrix(u, v)).norm(), 1e-12);
  }
}

TEST(BezierPatch, PassesThroughItsFourCorners) {
  std::mt19937_64 random(2);
  const BezierPatch patch = RandomPatch(random);
  EXPECT_EQ(patch.Point(0, 0), patch.control_point(0, 0));
  EXPECT_EQ(patch.Point(0, 1), patch.control_point(0, 3));
  EXPECT_EQ(patch.Point(1, 0), patch.control_point(3, 0));
  EXPECT_EQ(patch.Point(1, 1), patch.control_point(3, 3));
}

TEST(BezierPatch, ReproducesACubicAndItsDerivatives) {
  const BezierPatch patch = CubicGraph();
  const double u = 0.3;
  const double v = 0.8;
  EXPECT_LT((patch.Point(u, v) - Vector3d(u, v, u * u * u * v * v * v)).norm(), 1e-15);
  EXPECT_LT((patch.DerivativeU(u, v) - Vector3d(1, 0, 3 * u * u * v * v * v)).norm(), 1e-14);
  EXPECT_LT((patch.DerivativeV(u, v) - Vector3d(0, 1, 3 * u * u * u * v * v)).norm(), 1e-14);
  const Vector3d normal(-3 * u * u * v * v * v, -3 * u * u * u * v * v, 1);
  EXPECT_LT((patch.Normal(u, v) - normal.normalized()).norm(), 1e-14);
}

TEST(BezierPatch, TakesTheLimitNormalWhereBothTangentsAreParallel) {
  // At the corner (0, 0) both edges run along x, in opposite directions: S_u × S_v = 0, as in a lens. The patch is
  // flat.
  BezierPatch::ControlNet net = CubicGraph().control_net();
  net[3][3].z() = 0.0;
  net[1][0] = {0.3, 0, 0};
  net[0][1] = {-0.3, 0, 0};
  const BezierPatch patch(net);
  ASSERT_LT(patch.DerivativeU(0, 0).cross(patch.DerivativeV(0, 0)).norm(), 1e-15);
  EXPECT_LT((patch.Normal(0, 0) - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((patch.Normal(1e-6, 1e-6) - Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(BezierPatch, TakesTheLimitNormalWhereAnEdgeIsAPoint) {
  BezierPatch::ControlNet net = CubicGraph().control_net();
  net[3][3].z() = 0.0;
  for (Vector3d& q : net[0]) q = Vector3d::Zero();
  EXPECT_LT((BezierPatch(net).Normal(0, 0.5) - Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(BezierPatch, SplitsIntoHalvesOfTheSameSurface) {
  std::mt19937_64 random(3);
  const BezierPatch patch = RandomPatch(random);
  const auto [low, high] = patch.Split(PatchDirection::kU, 0.3);
  EXPECT_LT((low.Point(0.5, 0.7) - patch.Point(0.15, 0.7)).norm(), 1e-12);
  EXPECT_LT((high.Point(0.5, 0.7) - patch.Point(0.65, 0.7)).norm(), 1e-12);
  const auto [left, right] = patch.Split(PatchDirection::kV, 0.25);
  EXPECT_LT((left.Point(0.4, 1.0) - patch.Point(0.4, 0.25)).norm(), 1e-12);
  EXPECT_LT((right.Point(0.4, 0.2) - patch.Point(0.4, 0.4)).norm(), 1e-12);
}

TEST(BezierPatch, FlippedIsTheSameSurfaceSeenFromBehind) {
  std::mt19937_64 random(4);
  const BezierPatch patch = RandomPatch(random);
  EXPECT_LT((patch.Flipped().Point(0.2, 0.9) - patch.Point(0.9, 0.2)).norm(), 1e-12);
  EXPECT_LT((patch.Flipped().Normal(0.2, 0.9) + patch.Normal(0.9, 0.2)).norm(), 1e-12);
}

TEST(BezierPatch, TessellatesToTrianglesThatFaceAlongItsNormal) {
  BezierPatch::ControlNet net = CubicGraph().control_net();
  net[3][3].z() = 0.0;
  const TriangleMesh mesh = Tessellate(BezierPatch(net), 4, 3);
  EXPECT_EQ(mesh.vertices.size(), 20U);
  EXPECT_EQ(mesh.faces.size(), 24U);
  EXPECT_NEAR(SurfaceArea(mesh), 1.0, 1e-12);  // The unit square.
  for (const Vector3d& normal : VertexNormals(mesh)) EXPECT_GT(normal.z(), 0.999);
}

TEST(BezierTube, JoinsItsTwoPatchesWithC1AlongBothSeams) {
  const BezierTube tube = StraightTube();
  for (double u = 0.0; u <= 1.0; u += 0.125) {
    EXPECT_LT((tube.a().Point(u, 1) - tube.b().Point(u, 0)).norm(), 1e-12);
    EXPECT_LT((tube.a().DerivativeV(u, 1) - tube.b().DerivativeV(u, 0)).norm(), 1e-12);
    EXPECT_LT((tube.b().Point(u, 1) - tube.a().Point(u, 0)).norm(), 1e-12);
    EXPECT_LT((tube.b().DerivativeV(u, 1) - tube.a().DerivativeV(u, 0)).norm(), 1e-12);
  }
}

TEST(BezierTube, IsThreeQuartersAsDeepAsItsControlPolygon) {
  // Cubic with control depths 0, e, e, 0: 3e/4 at its middle, on both sides.
  const BezierTube tube = StraightTube();
  EXPECT_NEAR(tube.Point(0.4, 0.25).y(), 0.75 * 2.0, 1e-12);
  EXPECT_NEAR(tube.Point(0.4, 0.75).y(), -0.75 * 2.0, 1e-12);
  EXPECT_NEAR(tube.Point(0.4, 0.0).z(), -3.0, 1e-12);
  EXPECT_NEAR(tube.Point(0.4, 0.5).z(), 3.0, 1e-12);
}

TEST(BezierTube, CappedTubeIsClosedAndHoldsItsSectionTimesItsLength) {
  // Area of the section: x(t) = w(-1 + 6t² - 4t³) runs from -w to w, y(t) = 3e·t(1 - t); twice ∫ y x' dt
  // = 2 · 36·w·e ∫ t²(1 - t)² dt = 72·w·e/30 = 2.4·w·e with w = 3, e = 2, length 30: 432 mm³.
  const std::vector<BezierTube> chain{StraightTube()};
  const TriangleMesh mesh = Tessellate(ShellOfTubes("tube", chain, TubeEnds::kCapped), {8, 64, 1});
  EXPECT_EQ(CountOpenEdges(mesh), 0U);
  EXPECT_NEAR(SignedVolume(mesh), 432.0, 0.5);
}

TEST(BezierTube, MirroredTubeStillPointsOutward) {
  const std::vector<BezierTube> chain{StraightTube().MirroredX()};
  const TriangleMesh mesh = Tessellate(ShellOfTubes("tube", chain, TubeEnds::kCapped), {8, 64, 1});
  EXPECT_EQ(CountOpenEdges(mesh), 0U);
  EXPECT_NEAR(SignedVolume(mesh), 432.0, 0.5);
}

}  // namespace
}  // namespace annulus
