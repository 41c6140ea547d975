#include "modeling/glasses/lens_thickness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modeling/glasses/lens_form.h"
#include "tests/modeling_lens/lens_shapes.h"
#include "tests/modeling_lens/reference_lens.h"

namespace annulus {
namespace {

using test::Ellipse;
using test::Rectangle;

/// −4 D on 4 D, n 1.5, 2 mm: radii 125 and 62.5 mm.
LensForm MinusFour() {
  LensForm form;
  form.index = 1.5;
  form.centre_thickness = 2.0;
  form.front.curvature_u = form.front.curvature_v = 1.0 / 125.0;
  form.back.curvature_u = form.back.curvature_v = 1.0 / 62.5;
  form.back.lens_from_surface.translation().z() = -2.0;
  form.back_point.z() = -2.0;
  return form;
}

/// Volume of a spherical cap of radius R over a disc of radius a: π h² (3R − h) / 3.
double Cap(double radius, double a) {
  const double h = radius - std::sqrt(radius * radius - a * a);
  return kPi * h * h * (3.0 * radius - h) / 3.0;
}

TEST(LensThickness, VolumeOfARoundLensIsThatOfItsCaps) {
  const double a = 29.0;
  const auto sag = [a](double radius) { return radius - std::sqrt(radius * radius - a * a); };
  // Between the surfaces: a disc of 2 mm, less what the front has lost, plus what the back has.
  const double volume =
      kPi * a * a * 2.0 - (kPi * a * a * sag(125.0) - Cap(125.0, a)) + (kPi * a * a * sag(62.5) - Cap(62.5, a));
  const LensBody body = BodyOf(MinusFour(), Ellipse(2.0 * a, 2.0 * a, 3600), 1.32);
  EXPECT_NEAR(body.volume / volume, 1.0, 2e-6);
  EXPECT_NEAR(body.weight, 1.32e-3 * volume, 1e-4);
  EXPECT_NEAR(body.centre_of_gravity.x(), 0.0, 1e-9);
  EXPECT_NEAR(body.centre_of_gravity.y(), 0.0, 1e-9);
  // A coarse outline loses the area between chord and arc only: 1 − sin(2π/n)/(2π/n) of a ring at the edge.
  const LensBody coarse = BodyOf(MinusFour(), Ellipse(2.0 * a, 2.0 * a, 180), 1.32);
  EXPECT_NEAR(coarse.volume / volume, 1.0, 1e-3);
}

TEST(LensThickness, VolumeAndBalanceOfABoxAreExact) {
  LensForm slab;
  slab.back.lens_from_surface.translation().z() = -3.0;
  const LensBody body = BodyOf(slab, Rectangle(50.0, 40.0), 1.2);
  EXPECT_NEAR(body.volume, 6000.0, 1e-8);
  EXPECT_NEAR(body.weight, 7.2, 1e-10);
  EXPECT_NEAR(body.centre_of_gravity.z(), -1.5, 1e-12);
}

TEST(LensThickness, AWedgeBalancesOnItsThickSide) {
  // Thickness 3 − 0.05·y over 50 × 40: ȳ = −∫0.05·y² / ∫3 = −0.05·(40²/12)/3.
  LensForm wedge;
  wedge.back.lens_from_surface.translation().z() = -3.0;
  wedge.back.lens_from_surface.linear() =
      Eigen::AngleAxisd(std::atan(0.05), Eigen::Vector3d::UnitX()).toRotationMatrix();
  const LensBody body = BodyOf(wedge, Rectangle(50.0, 40.0), 1.0);
  EXPECT_NEAR(body.volume, 6000.0, 1e-7);
  EXPECT_NEAR(body.centre_of_gravity.y(), -0.05 * (1600.0 / 12.0) / 3.0, 1e-9);
}

TEST(LensThickness, VolumeOfATiltedTorusIsThatOfAFineSum) {
  const LensForm form = test::ReferenceLens();
  const LensOutline outline = Rectangle(46.0, 34.0);
  double sum = 0.0;
  constexpr int kCells = 400;  // midpoint rule, independent of the quadrature
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      sum += form.Thickness(-23.0 + 46.0 * (i + 0.5) / kCells, -17.0 + 34.0 * (j + 0.5) / kCells);
    }
  }
  const double volume = sum * 46.0 * 34.0 / (kCells * kCells);
  EXPECT_NEAR(BodyOf(form, outline, 1.0).volume / volume, 1.0, 1e-5);
}

TEST(LensThickness, TheEdgeFollowsTheOutline) {
  const LensOutline outline = Ellipse(50.0, 40.0, 720, {1.0, -2.0});
  const LensEdge edge = EdgeOf(MinusFour(), outline, 360);
  ASSERT_EQ(edge.points.size(), 360U);
  const auto thickness = [](double r2) {
    return 2.0 - (125.0 - std::sqrt(125.0 * 125.0 - r2)) + (62.5 - std::sqrt(62.5 * 62.5 - r2));
  };
  for (const EdgePoint& point : edge.points) {
    EXPECT_NEAR(point.thickness(), thickness(point.position.squaredNorm()), 1e-9);
    const Eigen::Vector2d radius = point.position - Eigen::Vector2d(1.0, -2.0);
    EXPECT_NEAR(std::remainder(std::atan2(radius.y(), radius.x()) - point.angle, kTwoPi), 0.0, 1e-9);
  }
  EXPECT_NEAR(edge.points[0].position.x(), 26.0, 1e-9);
  // From the lens's vertex (0, 0) the farthest place of this ellipse is near its right end.
  EXPECT_NEAR(std::remainder(edge.thickest_angle, kTwoPi), 0.0, 0.35);
  EXPECT_LT(edge.thinnest, edge.thickest);
}

TEST(LensThickness, TheMapHoldsTheThicknessInsideAndNothingOutside) {
  const LensForm form = test::ReferenceLens();
  const LensOutline outline = Ellipse(50.0, 40.0);
  const ThicknessMap map = ThicknessMapOf(form, outline, 0.5);
  ASSERT_EQ(map.thickness.cols(), 101);
  ASSERT_EQ(map.thickness.rows(), 81);
  EXPECT_EQ(map.x0, -25.0);
  EXPECT_TRUE(std::isnan(map.thickness(0, 0)));
  EXPECT_NEAR(map.thickness(40, 50), 2.2, 1e-9);
  for (Eigen::Index row = 0; row < 81; ++row) {
    for (Eigen::Index column = 0; column < 101; ++column) {
      const double x = -25.0 + 0.5 * static_cast<double>(column);
      const double y = -20.0 + 0.5 * static_cast<double>(row);
      const double place = x * x / 625.0 + y * y / 400.0;
      if (place < 0.999) {
        EXPECT_NEAR(map.thickness(row, column), form.Thickness(x, y), 1e-12);
      }
      if (place > 1.001) {
        EXPECT_TRUE(std::isnan(map.thickness(row, column)));
      }
    }
  }
}

}  // namespace
}  // namespace annulus
