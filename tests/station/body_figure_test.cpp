#include "station/body_figure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace annulus {
namespace {

constexpr double kFront = std::numbers::pi / 2;

double AreaOf(const std::vector<Eigen::Vector2d>& loop) {
  double twice = 0.0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Eigen::Vector2d& a = loop[k];
    const Eigen::Vector2d& b = loop[(k + 1) % loop.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * twice;
}

/// A box from `low` to `high`, outward.
TriangleMesh Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) {
    mesh.vertices.emplace_back((k & 1) != 0 ? high.x() : low.x(), (k & 2) != 0 ? high.y() : low.y(),
                               (k & 4) != 0 ? high.z() : low.z());
  }
  mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(BodyFigure, LevelCurvesOfAConeAreCircles) {
  FigureGrid cone{81, 81, {}};
  for (int row = 0; row < 81; ++row) {
    for (int column = 0; column < 81; ++column) cone.values.push_back(40.0 - std::hypot(column - 40, row - 40));
  }
  const auto loops = LevelLoops(cone, 10.0);
  ASSERT_EQ(loops.size(), 1U);
  for (const Eigen::Vector2d& p : loops[0]) EXPECT_NEAR(std::hypot(p.x() - 40, p.y() - 40), 30.0, 0.01);
  EXPECT_NEAR(std::abs(AreaOf(loops[0])), std::numbers::pi * 900, 6.0);
}

TEST(BodyFigure, LevelCurvesCloseAtTheGridsEdgeAndGoAroundHoles) {
  // A plateau that fills the grid but for a pit in its middle.
  FigureGrid field{9, 9, std::vector<double>(81, 1.0)};
  field.values[4 * 9 + 4] = 0.0;
  const auto loops = LevelLoops(field, 0.5);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_LT(AreaOf(loops[0]) * AreaOf(loops[1]), 0.0);  // rim and hole turn opposite ways
}

TEST(BodyFigure, SaddlesGiveClosedCurves) {
  const FigureGrid field{4, 4, {0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}};
  EXPECT_EQ(LevelLoops(field, 0.5).size(), 2U);
}

TEST(BodyFigure, SimplifiedCurvesKeepTheirCorners) {
  const std::vector<Eigen::Vector2d> curve{{0, 0}, {1, 0.01}, {2, 0}, {2, 1}, {2, 2}};
  const auto simple = Simplified(curve, 0.05);
  ASSERT_EQ(simple.size(), 3U);
  EXPECT_EQ(simple[1], Eigen::Vector2d(2, 0));
}

TEST(BodyFigure, SeesTheFrontWithTheSubjectsRightOnTheLeft) {
  const BodyFigure figure(Box({-100, -50, 0}, {100, 50, 300}), kFront, 1.0);
  EXPECT_NEAR((figure.Project({100, 50, 20}) - Eigen::Vector2d(-100, 20)).norm(), 0.0, 1e-9);
  const auto outline = figure.Outline();
  ASSERT_EQ(outline.size(), 1U);
  EXPECT_NEAR(std::abs(AreaOf(outline[0])), 200.0 * 300.0, 600.0);
}

TEST(BodyFigure, TellsWhatTheBodyHides) {
  const BodyFigure figure(Box({-100, -50, 0}, {100, 50, 300}), kFront, 1.0);
  const auto front = figure.Runs({{-90, 50, 150}, {90, 50, 150}});
  ASSERT_EQ(front.size(), 1U);
  EXPECT_TRUE(front[0].visible);
  const auto back = figure.Runs({{-90, -50, 150}, {90, -50, 150}});
  ASSERT_EQ(back.size(), 1U);
  EXPECT_FALSE(back[0].visible);
  // Beside the body nothing hides: a line behind it that sticks out by 100 mm on either side.
  const auto across = figure.Runs({{-200, -50, 150}, {200, -50, 150}});
  ASSERT_EQ(across.size(), 3U);
  EXPECT_TRUE(across[0].visible);
  EXPECT_FALSE(across[1].visible);
  EXPECT_NEAR(std::abs(across[1].points.front().x()), 100.0, 5.0);
}

TEST(BodyFigure, OfNothingKnownHasNoFaces) {
  const SplineSurface surface(PeriodicCubicBasis(8), ClampedCubicBasis({0.0, 100.0}), Eigen::VectorXd::Ones(8 * 4));
  SurfaceModel model;
  model.segments.push_back({"body", surface, KnowledgeMap(4, 4, 0.0, 100.0), {}, {}, {}});
  EXPECT_TRUE(FigureMesh(model, -1000.0).faces.empty());
}

TEST(BodyFigure, LeavesOutArmsAndWhatIsBelow) {
  const SplineSurface surface(PeriodicCubicBasis(8), ClampedCubicBasis({0.0, 100.0}),
                              Eigen::VectorXd::Constant(8 * 4, 50.0));
  SurfaceModel model;
  model.segments.push_back({"body", surface, {}, {}, {}, {}});
  const TriangleMesh whole = FigureMesh(model, -1.0);
  model.segments.push_back({"left arm", surface, {}, {}, {}, {}});
  EXPECT_EQ(FigureMesh(model, -1.0).faces.size(), whole.faces.size());
  const TriangleMesh upper = FigureMesh(model, 50.0);
  EXPECT_FALSE(upper.faces.empty());
  for (const Eigen::Vector3d& vertex : upper.vertices) EXPECT_GE(vertex.z(), 50.0);
}

}  // namespace
}  // namespace annulus
