#include "modeling/clay/clay_to_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "modeling/clay/clay_closest.h"
#include "modeling/clay/clay_operation.h"
#include "modeling/clay/clay_shapes.h"
#include "tests/modeling_clay/clay_surfaces.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using test::Cylinder;
using test::Wavy;

ClayOfSurface Clay(const SurfaceSegment& segment) {
  auto made = ClayFromSurface(segment);
  EXPECT_TRUE(made) << (made ? "" : made.error().Text());
  return std::move(*made);
}

/// The waves of Wavy on a surface that is refined in its middle, with an axis that leans.
SurfaceSegment Refined() {
  RefinementFlags flags(1, std::vector<char>(24 * 8, 0));
  for (std::size_t cell = 3 * 24; cell < 5 * 24; ++cell) flags[0][cell] = 1;
  auto spline = std::make_shared<const HierarchicalSpline>(24, UniformBreakpoints(1000.0, 1400.0, 8), flags);
  Eigen::VectorXd active(static_cast<Eigen::Index>(spline->size()));
  for (Eigen::Index n = 0; n < active.size(); ++n) active[n] = 120.0 + 4.0 * std::sin(0.9 * static_cast<double>(n));
  SurfaceSegment segment{"body", spline->Surface(active), KnowledgeMap(12, 4, 1000.0, 1400.0), {}};
  segment.hierarchy = spline;
  segment.active = active;
  segment.axis.z_middle = 1200.0;
  segment.axis.at = {3.0, -5.0};
  segment.axis.slope = {0.05, 0.02};
  return segment;
}

TEST(SurfaceFromClay, GivesWhatWasNotTouchedBackToTheBit) {
  for (const SurfaceSegment& segment : {Wavy(), Refined()}) {
    const ClayOfSurface made = Clay(segment);
    EXPECT_LE(made.largest_error_mm, 1e-4);
    const auto back = SurfaceFromClay(segment, made, made.body);
    ASSERT_TRUE(back) << back.error().Text();
    EXPECT_EQ(back->segment.surface.coefficients(), segment.surface.coefficients());
    EXPECT_EQ(back->segment.active, segment.active);
    EXPECT_EQ(back->segment.surface.z_max(), segment.surface.z_max());
    EXPECT_EQ(back->largest_error_mm, 0.0);
    EXPECT_LE(std::abs(back->volume_error), 1e-7);
    EXPECT_EQ(back->caps_off_mm, 0.0);
  }
}

/// Clay made of another surface on the same grid, `stretched` in height: what comes back must be that one.
void ComesBackAs(const SurfaceSegment& other, const SurfaceSegment& segment) {
  const auto back = SurfaceFromClay(segment, Clay(segment), Clay(other).body);
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(back->segment.surface.z_min(), other.surface.z_min());
  EXPECT_EQ(back->segment.surface.z_max(), other.surface.z_max());
  double off = 0.0;
  for (int n = 0; n < 5000; ++n) {
    const double theta = 2.0 * std::numbers::pi * n / 5000.0;
    const double z =
        other.surface.z_min() + (other.surface.z_max() - other.surface.z_min()) * std::fmod(0.6180339887 * n, 1.0);
    off = std::max(off, std::abs(back->segment.surface.Radius(theta, z) - other.surface.Radius(theta, z)));
  }
  // Both clays are within 1e-4 mm of their surfaces.
  EXPECT_LE(off, 2.5e-4);
  EXPECT_LE(back->largest_error_mm, 2.5e-4);
  EXPECT_LE(std::abs(back->volume_error), 2e-7);
}

TEST(SurfaceFromClay, FindsASurfaceThatIsKnown) {
  SurfaceSegment other = Wavy();
  Eigen::VectorXd coefficients = other.surface.coefficients();
  for (Eigen::Index n = 0; n < coefficients.size(); ++n)
    coefficients[n] += 5.0 * std::cos(1.3 * static_cast<double>(n));
  other.surface = SplineSurface(other.surface.theta_basis(), other.surface.z_basis(), coefficients);
  ComesBackAs(other, Wavy());
}

TEST(SurfaceFromClay, TakesTheKnotsAlongWhereTheEndsMoved) {
  SurfaceSegment other = Wavy();
  std::vector<double> breaks = other.surface.z_basis().breakpoints();
  for (double& z : breaks) z = 1.07 * z - 12.0;
  other.surface = SplineSurface(other.surface.theta_basis(), ClampedCubicBasis(breaks), other.surface.coefficients());
  ComesBackAs(other, Wavy());
}

TEST(SurfaceFromClay, FollowsAPushAndItsSwelling) {
  for (const int model : {1, 2}) {
    const SurfaceSegment segment = Refined();
    const ClayOfSurface made = Clay(segment);
    ClayBody shaped = made.body;
    ToolHold hold;
    hold.at = {3 * 24 + 7, 0.5, 0.5};
    hold.radius_mm = 60.0;
    ASSERT_TRUE(Perform(shaped, PushAct{hold, 6.0, model, 1.6}));
    SurfaceOfClayOptions own;
    own.tolerance_mm = std::numeric_limits<double>::infinity();
    const auto coarse = SurfaceFromClay(segment, made, shaped, own);
    ASSERT_TRUE(coarse) << coarse.error().Text();
    EXPECT_EQ(coarse->pieces_split, 0U);
    EXPECT_GT(coarse->largest_error_mm, 0.1);
    const auto back = SurfaceFromClay(segment, made, shaped);
    ASSERT_TRUE(back) << back.error().Text();
    // Its own knots, 25 … 50 mm apart, do not follow a finger of 60 mm; finer ones do.
    EXPECT_LE(back->largest_error_mm, 0.1);
    EXPECT_GT(back->largest_growth_mm, 5.0);
    EXPECT_GT(back->pieces_split, 100U);
    EXPECT_LE(std::abs(back->volume_error), 1e-7);
    // How far it is from the clay, found another way: nearest points of the skin.
    double off = 0.0;
    for (int n = 0; n < 400; ++n) {
      const double z = 1030.0 + 340.0 * std::fmod(0.6180339887 * n, 1.0);
      const Vector3d point = back->segment.Point(2.0 * std::numbers::pi * n / 400.0, z);
      off = std::max(off, (shaped.Point(ClosestAddress(shaped, point)) - point).norm());
    }
    EXPECT_LE(off, back->largest_error_mm + made.largest_error_mm);
  }
}

TEST(SurfaceFromClay, RefusesAnUndercutAndSaysWhere) {
  const SurfaceSegment segment = Cylinder(120.0, 500.0);
  const ClayOfSurface made = Clay(segment);
  ClayBody shaped = made.body;
  ToolHold hold;
  hold.at = {5 * 36 + 9, 0.0, 0.0};  // theta 90 degrees, z 250 mm
  hold.radius_mm = 30.0;
  ASSERT_TRUE(Perform(shaped, PushAct{hold, -25.0, 1, 2.0}));
  hold.direction = Vector3d(0.0, 0.0, 1.0);
  hold.radius_mm = 20.0;
  for (int n = 0; n < 6; ++n) {
    const auto lifted = Perform(shaped, PushAct{hold, 4.0, 2, 2.0});
    ASSERT_TRUE(lifted) << n << lifted.error().Text();
  }
  const auto back = SurfaceFromClay(segment, made, shaped);
  ASSERT_FALSE(back);
  EXPECT_NE(back.error().seen.find("undercut"), std::string::npos) << back.error().Text();
  EXPECT_NE(back.error().seen.find("theta"), std::string::npos);
}

TEST(SurfaceFromClay, RefusesClayOfAnotherModel) {
  const SurfaceSegment segment = Cylinder(120.0, 500.0);
  const auto back = SurfaceFromClay(segment, Clay(segment), *ClayBody::Make(ClayBlock()));
  ASSERT_FALSE(back);
  EXPECT_NE(back.error().seen.find("it has 144 patches"), std::string::npos) << back.error().Text();
}

}  // namespace
}  // namespace annulus
