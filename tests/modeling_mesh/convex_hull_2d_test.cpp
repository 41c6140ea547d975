#include "modeling/mesh/convex_hull_2d.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/units.h"

namespace annulus {
namespace {

TEST(ConvexHull, KeepsAllPointsOfACircle) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(std::cos(kTwoPi * i / 100), std::sin(kTwoPi * i / 100));
  EXPECT_EQ(ConvexHull(points).size(), 100U);
  EXPECT_NEAR(ConvexHullPerimeter(points), 200.0 * std::sin(kPi / 100), 1e-12);
}

TEST(ConvexHull, BridgesADent) {
  // A square with a notch: the tape goes straight over it.
  const std::vector<Eigen::Vector2d> points{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}, {2, 0}, {4, 2}};
  EXPECT_DOUBLE_EQ(ConvexHullPerimeter(points), 16.0);
  const std::vector<Eigen::Vector2d> hull = ConvexHull(points);
  ASSERT_EQ(hull.size(), 4U);
  EXPECT_EQ(hull[0], Eigen::Vector2d(0, 0));
  EXPECT_EQ(hull[1], Eigen::Vector2d(4, 0));
  EXPECT_EQ(hull[2], Eigen::Vector2d(4, 4));
}

TEST(ConvexHull, CopesWithFewOrFlatPoints) {
  EXPECT_EQ(ConvexHullPerimeter({}), 0.0);
  EXPECT_EQ(ConvexHullPerimeter({{1, 2}}), 0.0);
  EXPECT_EQ(ConvexHullPerimeter({{1, 2}, {1, 2}}), 0.0);
  EXPECT_DOUBLE_EQ(ConvexHullPerimeter({{0, 0}, {3, 4}, {1.5, 2}}), 10.0);
}

TEST(ConvexHull, HoldsEveryPointWhateverTheirOrder) {
  std::mt19937 random(2);
  std::normal_distribution<double> place;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 500; ++i) points.emplace_back(place(random), place(random));
  const std::vector<Eigen::Vector2d> hull = ConvexHull(points);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    for (const Eigen::Vector2d& p : points) {
      EXPECT_GE(edge.x() * (p - hull[i]).y() - edge.y() * (p - hull[i]).x(), -1e-12);
    }
  }
  std::reverse(points.begin(), points.end());
  EXPECT_EQ(ConvexHull(points), hull);
}

}  // namespace
}  // namespace annulus
