#include "modeling/glasses/lens_bevel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

/// A round edge of radius 25 mm whose front lies at −2 mm and whose back at −2 mm − thickness(angle).
LensEdge RoundEdge(double thin, double thick) {
  LensEdge edge;
  for (int i = 0; i < 90; ++i) {
    EdgePoint point;
    point.angle = kTwoPi * i / 90.0;
    point.position = 25.0 * Eigen::Vector2d(std::cos(point.angle), std::sin(point.angle));
    point.front_z = -2.0;
    point.back_z = -2.0 - (0.5 * (thin + thick) - 0.5 * (thick - thin) * std::cos(point.angle));
    edge.points.push_back(point);
  }
  return edge;
}

TEST(LensBevel, FrontFollowKeepsItsDistance) {
  BevelRule rule;
  rule.mode = BevelMode::kFrontFollow;
  rule.front_distance = 0.8;
  const LensBevel bevel = BevelOf(RoundEdge(2.0, 4.0), Eigen::Vector2d::Zero(), rule);
  for (const double z : bevel.apex_z) EXPECT_DOUBLE_EQ(z, -2.8);
  EXPECT_NEAR(bevel.smallest_front, 0.8, 1e-12);
  EXPECT_NEAR(bevel.smallest_back, 1.2, 1e-12);
  EXPECT_NEAR(bevel.unevenness, 0.0, 1e-12);
}

TEST(LensBevel, HalfAndHalfLiesInTheMiddle) {
  const LensBevel bevel = BevelOf(RoundEdge(2.0, 4.0), Eigen::Vector2d::Zero(), BevelRule{});
  EXPECT_NEAR(bevel.apex_z[0], -3.0, 1e-12);
  EXPECT_NEAR(bevel.apex_z[45], -4.0, 1e-12);
  EXPECT_NEAR(bevel.mean_z, -3.5, 1e-12);
  EXPECT_NEAR(bevel.unevenness, 0.5, 1e-12);
}

TEST(LensBevel, AFlatCurveIsAPlaneHalfABevelBehindTheFront) {
  BevelRule rule;
  rule.mode = BevelMode::kCurve;
  rule.curve = 0.0;
  rule.width = 1.4;
  const LensBevel bevel = BevelOf(RoundEdge(2.0, 4.0), Eigen::Vector2d::Zero(), rule);
  EXPECT_NEAR(bevel.unevenness, 0.0, 1e-12);
  EXPECT_NEAR(bevel.mean_z, -2.7, 1e-12);
}

TEST(LensBevel, ACurveHasTheRadiusOfItsTool) {
  BevelRule rule;
  rule.mode = BevelMode::kCurve;
  rule.curve = 5.0;  // radius 106 mm
  LensEdge edge = RoundEdge(3.0, 3.0);
  for (std::size_t i = 0; i < 45; ++i) edge.points[i].position *= 0.8;  // 20 mm on one half
  const LensBevel bevel = BevelOf(edge, Eigen::Vector2d::Zero(), rule);
  const auto sag = [](double r) { return 106.0 - std::sqrt(106.0 * 106.0 - r * r); };
  EXPECT_NEAR(bevel.apex_z[0] - bevel.apex_z[60], sag(25.0) - sag(20.0), 1e-12);
  EXPECT_NEAR(bevel.smallest_front, 0.7, 1e-12);
}

TEST(LensBevel, ATooThinEdgeShowsInTheSmallestDistances) {
  BevelRule rule;
  rule.mode = BevelMode::kCurve;
  rule.curve = 0.0;
  const LensBevel bevel = BevelOf(RoundEdge(1.0, 4.0), Eigen::Vector2d::Zero(), rule);
  EXPECT_NEAR(bevel.smallest_front, 0.5, 1e-12);
  EXPECT_NEAR(bevel.smallest_back, 0.5, 1e-12);
  EXPECT_LT(bevel.smallest_back, rule.width / 2.0);
}

}  // namespace
}  // namespace annulus
