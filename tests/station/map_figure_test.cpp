#include "station/map_figure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>

namespace annulus {
namespace {

TEST(MapFigure, HasAScaleBarOfARoundLengthWhateverTheScale) {
  const std::regex label(">([0-9.]+) mm<");
  for (int n = -30; n <= 30; ++n) {
    MapPanel panel;
    panel.image = RgbImage::Filled(60, 8, LinearRgb::Ones());
    panel.pixels_per_mm = std::pow(10.0, 0.05 * n);
    const std::string svg = MapFigure({panel}, std::nullopt, {"scale", {}}, 4.5).ToSvg();
    std::smatch found;
    ASSERT_TRUE(std::regex_search(svg, found, label)) << panel.pixels_per_mm;
    const double length = std::stod(found[1]);
    // 1, 2 or 5 times a power of ten, as long as it may be: 0.3 of the panel.
    const double most = 0.3 * 60.0 / panel.pixels_per_mm;
    EXPECT_LE(length, most * (1.0 + 1e-9));
    EXPECT_GT(length, most / 2.5 * (1.0 - 1e-9));
    const double digit = length / std::pow(10.0, std::floor(std::log10(length) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1.0) < 1e-9 || std::abs(digit - 2.0) < 1e-9 || std::abs(digit - 5.0) < 1e-9) << length;
  }
}

}  // namespace
}  // namespace annulus
