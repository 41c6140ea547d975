#include "render/xy_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace annulus {
namespace {

/// Number of pixels of about a colour, and their middle column and row.
struct Patch {
  std::size_t count = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
};

Patch Find(const RgbImage& image, const LinearRgb& colour) {
  Patch patch;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if ((image.rgb[image.Index(x, y)] - colour).cwiseAbs().maxCoeff() > 0.02F) continue;
      ++patch.count;
      patch.middle += Eigen::Vector2d(x, y);
    }
  }
  if (patch.count > 0) patch.middle /= static_cast<double>(patch.count);
  return patch;
}

const LinearRgb kRed = LinearFromHex(0xff0000);
const LinearRgb kBlue = LinearFromHex(0x0000ff);

XySeries Mark(double x, double y, const LinearRgb& colour) { return {{{x, y}}, "", colour, XyMark::kDisc, 5}; }

TEST(XyPlot, PutsLargerValuesToTheRightAndUp) {
  const auto image = RenderXyPlot({Mark(0.0, 0.0, kRed), Mark(10.0, 5.0, kBlue)}, {});
  ASSERT_TRUE(image.has_value());
  const Patch red = Find(*image, kRed);
  const Patch blue = Find(*image, kBlue);
  EXPECT_NEAR(static_cast<double>(red.count), 78.5, 12.0);  // pi·5²
  EXPECT_GT(blue.middle.x(), red.middle.x() + 300.0);
  EXPECT_LT(blue.middle.y(), red.middle.y() - 200.0);
}

TEST(XyPlot, KeepsTheScaleEqualWhereAsked) {
  XyPlotStyle style;
  style.scale = AxisScale::kEqual;
  const auto image = RenderXyPlot({Mark(0.0, 0.0, kRed), Mark(100.0, 50.0, kBlue)}, style);
  ASSERT_TRUE(image.has_value());
  const Eigen::Vector2d step = Find(*image, kBlue).middle - Find(*image, kRed).middle;
  EXPECT_NEAR(step.x(), -2.0 * step.y(), 2.0);
}

TEST(XyPlot, SpansTheRangeThatItIsGiven) {
  XyPlotStyle style;
  style.width = 484;  // 400 pixels between the edges
  style.x_range = {{0.0, 400.0}};
  const auto image = RenderXyPlot({Mark(100.0, 0.0, kRed), Mark(300.0, 1.0, kBlue)}, style);
  ASSERT_TRUE(image.has_value());
  EXPECT_NEAR(Find(*image, kRed).middle.x(), 166.0, 1.5);
  EXPECT_NEAR(Find(*image, kBlue).middle.x(), 366.0, 1.5);
}

TEST(XyPlot, LeavesOutPointsThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const XySeries line{{{0.0, 0.0}, {1.0, nan}, {2.0, 1e300}, {3.0, 1.0}}, "line", kRed, XyMark::kLine, 3};
  EXPECT_TRUE(RenderXyPlot({line}, {}).has_value());
  const XySeries nothing{{{nan, nan}}, "", kRed, XyMark::kLine, 3};
  EXPECT_FALSE(RenderXyPlot({nothing}, {}).has_value());
  EXPECT_FALSE(RenderXyPlot({}, {}).has_value());
}

TEST(XyPlot, DrawsASinglePlaceAndAFlatLine) {
  EXPECT_TRUE(RenderXyPlot({Mark(7.0, -3.0, kRed)}, {}).has_value());
  EXPECT_TRUE(RenderXyPlot({{{{0.0, 5.0}, {1.0, 5.0}}, "flat", kRed, XyMark::kLine, 1}}, {}).has_value());
}

TEST(XyPlot, RefusesASizeOrRangeThatIsNone) {
  XyPlotStyle style;
  style.width = 100;
  EXPECT_FALSE(RenderXyPlot({Mark(0.0, 0.0, kRed)}, style).has_value());
  style = {};
  style.x_range = {{1.0, 1.0}};
  EXPECT_FALSE(RenderXyPlot({Mark(0.0, 0.0, kRed)}, style).has_value());
}

}  // namespace
}  // namespace annulus
