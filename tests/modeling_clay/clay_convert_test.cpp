#include "modeling/clay/clay_convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "modeling/clay/clay_operation.h"
#include "tests/modeling_clay/clay_check.h"
#include "tests/modeling_clay/clay_surfaces.h"

namespace annulus {
namespace {

using test::Cylinder;
using test::Wavy;

TEST(ClayFromSurface, OfACylinderHasItsVolume) {
  const auto made = ClayFromSurface(Cylinder(120.0, 500.0));
  ASSERT_TRUE(made) << made.error().Text();
  EXPECT_LE(made->largest_error_mm, 1e-4);
  EXPECT_EQ(made->columns, 36U);
  EXPECT_EQ(made->rows, 10U);
  EXPECT_NEAR(made->body.volume() / (std::numbers::pi * 120.0 * 120.0 * 500.0), 1.0, 1e-7);
  EXPECT_EQ(test::Unsound(made->body.mesh(), 1e-9), "");
}

TEST(ClayFromSurface, FollowsWavesAndLeavesNoGap) {
  const SurfaceSegment segment = Wavy();
  const auto made = ClayFromSurface(segment);
  ASSERT_TRUE(made) << made.error().Text();
  EXPECT_LE(made->largest_error_mm, 1e-4);
  EXPECT_EQ(test::Unsound(made->body.mesh(), 1e-9), "");
  // ∬ r²/2 dθ dz: Gauss with five nodes in each cell is exact, r² having degree 6 in either direction.
  const std::vector<double> x{0.04691007703066802, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332};
  const std::vector<double> w{0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                              0.11846344252809454};
  double volume = 0.0;
  for (int j = 0; j < 10; ++j) {
    for (int i = 0; i < 36; ++i) {
      for (std::size_t b = 0; b < 5; ++b) {
        for (std::size_t a = 0; a < 5; ++a) {
          const double r = segment.surface.Radius(2.0 * std::numbers::pi * (i + x[a]) / 36.0, 40.0 * (j + x[b]));
          volume += 0.5 * r * r * w[a] * w[b] * 40.0 * 2.0 * std::numbers::pi / 36.0;
        }
      }
    }
  }
  EXPECT_NEAR(made->body.volume() / volume, 1.0, 1e-7);
}

TEST(ClayFromSurface, TakesADentOfFixedCostInASmallPart) {
  auto made = ClayFromSurface(Wavy());
  ASSERT_TRUE(made);
  ToolHold hold;
  hold.at = {5 * 36 + 9, 0.5, 0.5};
  hold.radius_mm = 15.0;
  const auto report = Perform(made->body, PushAct{hold, 4.0, 1, 2.0});
  ASSERT_TRUE(report) << report.error().Text();
  EXPECT_LE(std::abs(report->volume_after_mm3 / report->volume_before_mm3 - 1.0), 1e-12);
  EXPECT_LT(report->touched, 400U);
  EXPECT_EQ(test::Unsound(made->body.mesh(), 1e-9), "");
}

TEST(ClayFromSurface, SaysSoWhenItIsNotEnough) {
  const auto few = ClayFromSurface(Wavy(), 1e-9, 1000);
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().seen.find("more than 1000 patches"), std::string::npos);
  EXPECT_FALSE(ClayFromSurface(Cylinder(-5.0, 100.0)));
}

}  // namespace
}  // namespace annulus
