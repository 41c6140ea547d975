#include "modeling/clay/clay_girths.h"

#include <gtest/gtest.h>

#include <numbers>

#include "modeling/clay/clay_operation.h"
#include "modeling/clay/clay_shapes.h"
#include "tests/modeling_clay/clay_check.h"
#include "tests/modeling_clay/clay_surfaces.h"

namespace annulus {
namespace {

TEST(ClayGirths, OfACylinderAreItsCircles) {
  const auto made = ClayFromSurface(test::Cylinder(120.0, 500.0));
  ASSERT_TRUE(made);
  const ClayGirths girths(made->body, {33.3, 250.0, 250.1, 700.0});
  for (std::size_t level = 0; level < 3; ++level) {
    EXPECT_NEAR(girths.Perimeter(level) / (2.0 * std::numbers::pi * 120.0), 1.0, 1e-6);
    EXPECT_NEAR(girths.Tape(level) / (2.0 * std::numbers::pi * 120.0), 1.0, 1e-4);
  }
  EXPECT_EQ(girths.Perimeter(3), 0.0);
  EXPECT_EQ(girths.Tape(3), 0.0);
}

TEST(ClayGirths, OfABlockAreItsOutline) {
  const auto body = ClayBody::Make(ClayBlock());
  const ClayGirths girths(*body, {-1.7});
  EXPECT_NEAR(girths.Perimeter(0), 24.0, 1e-12);
  EXPECT_NEAR(girths.Tape(0), 24.0, 1e-12);
}

TEST(ClayGirths, FollowWhatIsDone) {
  auto made = ClayFromSurface(test::Wavy());
  ASSERT_TRUE(made);
  ClayBody& body = made->body;
  const std::vector<double> levels{180.0, 205.0, 220.0, 300.0};
  ClayGirths girths(body, levels);
  const double far = girths.Perimeter(3);
  ToolHold hold;
  hold.at = {5 * 36 + 9, 0.5, 0.5};
  hold.radius_mm = 15.0;
  for (const int model : {1, 2, 1}) {
    ASSERT_TRUE(Perform(body, PushAct{hold, 3.0, model, 2.0}));
    girths.Follow(body);
    const ClayGirths anew(body, levels);
    for (std::size_t level = 0; level < levels.size(); ++level) {
      EXPECT_EQ(girths.Perimeter(level), anew.Perimeter(level));
      EXPECT_EQ(girths.Tape(level), anew.Tape(level));
    }
  }
  EXPECT_NE(girths.Perimeter(1), far);
}

}  // namespace
}  // namespace annulus
