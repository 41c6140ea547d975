#include "render/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/units.h"

namespace annulus {
namespace {

/// Pixels whose sRGB bytes are those of `colour`.
std::vector<Eigen::Vector2i> PixelsOf(const RgbImage& image, const LinearRgb& colour) {
  std::vector<Eigen::Vector2i> found;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const LinearRgb& rgb = image.rgb[image.Index(x, y)];
      bool same = true;
      for (int c = 0; c < 3; ++c) same = same && SrgbByteFromLinear(rgb[c]) == SrgbByteFromLinear(colour[c]);
      if (same) found.emplace_back(x, y);
    }
  }
  return found;
}

Eigen::Vector2i SpanOf(const std::vector<Eigen::Vector2i>& pixels) {
  Eigen::Vector2i low(1 << 20, 1 << 20);
  Eigen::Vector2i high(-1, -1);
  for (const Eigen::Vector2i& p : pixels) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return high - low + Eigen::Vector2i(1, 1);
}

TEST(HeatMap, CellsHaveTheColourOfTheirValue) {
  Eigen::MatrixXd values(2, 4);
  values << 0.0, 0.3, 0.6, 1.0, std::nan(""), 0.3, 0.6, 2.0;
  HeatMapStyle style;
  style.map = ColourMap::kSequential;
  style.minimum = 0.0;
  style.maximum = 1.0;
  style.width = 564;   // 400 columns of data
  style.height = 282;  // 200 rows of data
  const auto image = RenderHeatMap(values, style);
  ASSERT_TRUE(image.has_value());
  ASSERT_EQ(image->width, 564);
  ASSERT_EQ(image->height, 282);
  // One cell of 100 x 100 pixels without a value, drawn at the lower left.
  const auto missing = PixelsOf(*image, kNoDataColour);
  EXPECT_GE(missing.size(), 10000U);  // soft edges of letters may hit the same grey
  EXPECT_LE(missing.size(), 10050U);
  // Two cells of 0.3 and two of 0.6; the legend passes each colour in a few rows more at most.
  for (const double value : {0.3, 0.6}) {
    const std::size_t count = PixelsOf(*image, MapColour(ColourMap::kSequential, value)).size();
    EXPECT_GE(count, 20000U);
    EXPECT_LE(count, 20200U);
  }
  // Beyond the range the last colour is used: two cells.
  EXPECT_GE(PixelsOf(*image, MapColour(ColourMap::kSequential, 1.0)).size(), 20000U);
}

TEST(HeatMap, RefusesWhatItCannotDraw) {
  HeatMapStyle style;
  EXPECT_FALSE(RenderHeatMap(Eigen::MatrixXd(0, 0), style).has_value());
  const Eigen::MatrixXd values = Eigen::MatrixXd::Zero(3, 3);
  style.maximum = style.minimum;
  EXPECT_FALSE(RenderHeatMap(values, style).has_value());
  style = HeatMapStyle{};
  style.y_to = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(RenderHeatMap(values, style).has_value());
  style = HeatMapStyle{};
  style.width = 10;
  EXPECT_FALSE(RenderHeatMap(values, style).has_value());
  style = HeatMapStyle{};
  style.title = "\xC3\xA9 \xC2\xB0 \xE3\x83\xA1 \n";  // not in the stroke font: replaced, not refused
  EXPECT_TRUE(RenderHeatMap(values, style).has_value());
}

std::vector<Eigen::Vector2d> Ellipse(double a, double b) {
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 360; ++k) points.emplace_back(a * std::cos(kPi * k / 180.0), b * std::sin(kPi * k / 180.0));
  return points;
}

TEST(SectionPlot, AxesAreEqual) {
  const LinearRgb red = LinearFromHex(0xd01010);
  const auto image = RenderSectionPlot({{Ellipse(180.0, 90.0), "", red}}, {"a section", 600, 400});
  ASSERT_TRUE(image.has_value());
  const Eigen::Vector2i span = SpanOf(PixelsOf(*image, red));
  // Line width and soft edges add up to 3 pixels to each span.
  EXPECT_NEAR(static_cast<double>(span.x() - 2) / (span.y() - 2), 2.0, 0.03);
  EXPECT_NEAR(span.x(), 0.94 * (600 - 32), 4.0);
}

TEST(SectionPlot, DrawsSeveralCurvesAndSkipsBrokenPoints) {
  auto broken = Ellipse(50.0, 50.0);
  broken[10].x() = std::nan("");
  const auto image = RenderSectionPlot({{Ellipse(80.0, 60.0), "fitted", LinearFromHex(0x2050b0)},
                                        {broken, "true", LinearFromHex(0xd01010)},
                                        {{}, "empty", LinearFromHex(0x10a010)}},
                                       {"", 300, 300});
  ASSERT_TRUE(image.has_value());
  EXPECT_GT(PixelsOf(*image, LinearFromHex(0x2050b0)).size(), 200U);
  EXPECT_GT(PixelsOf(*image, LinearFromHex(0xd01010)).size(), 150U);
}

TEST(SectionPlot, RefusesNothingToDraw) {
  EXPECT_FALSE(RenderSectionPlot({}, {"", 300, 300}).has_value());
  const Eigen::Vector2d nowhere(std::nan(""), 0.0);
  EXPECT_FALSE(RenderSectionPlot({{{nowhere}, "", LinearRgb::Zero()}}, {"", 300, 300}).has_value());
  EXPECT_FALSE(RenderSectionPlot({{Ellipse(1.0, 1.0), "", LinearRgb::Zero()}}, {"", 0, 300}).has_value());
  EXPECT_TRUE(RenderSectionPlot({{{{5.0, 5.0}}, "point", LinearRgb::Zero()}}, {"", 300, 300}).has_value());
}

}  // namespace
}  // namespace annulus
