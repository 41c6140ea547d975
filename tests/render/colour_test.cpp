#include "render/colour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/colour_map.h"

namespace annulus {
namespace {

// python3: lin = lambda e: e/12.92 if e <= 0.04045 else ((e+0.055)/1.055)**2.4
//          for e in (0.02, 0.04045, 0.1, 0.5, 0.8, 1): print(e, repr(lin(e)))
TEST(Colour, FollowsTheIecTransferFunction) {
  EXPECT_NEAR(LinearFromSrgb(0.02), 0.0015479876160990713, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.04045), 0.0031308049535603713, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.1), 0.010022825574869039, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.5), 0.21404114048223255, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.8), 0.6038273388553378, 1e-15);
  EXPECT_EQ(LinearFromSrgb(1.0), 1.0);
  // python3: enc = lambda l: 12.92*l if l <= 0.0031308 else 1.055*l**(1/2.4)-0.055
  EXPECT_NEAR(SrgbFromLinear(0.001), 0.01292, 1e-15);
  EXPECT_NEAR(SrgbFromLinear(0.18), 0.46135612950044164, 1e-14);
  EXPECT_NEAR(SrgbFromLinear(0.5), 0.7353569830524495, 1e-14);
}

TEST(Colour, ClampsWhatCannotBeShown) {
  EXPECT_EQ(SrgbFromLinear(-1.0), 0.0);
  EXPECT_DOUBLE_EQ(SrgbFromLinear(7.0), 1.0);
  EXPECT_EQ(SrgbFromLinear(std::nan("")), 0.0);
  EXPECT_EQ(SrgbByteFromLinear(-1.0F), 0);
  EXPECT_EQ(SrgbByteFromLinear(1.5F), 255);
  EXPECT_EQ(SrgbByteFromLinear(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(SrgbByteFromLinear(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Colour, BytesAreTheRoundedTransferFunction) {
  for (int k = 0; k <= 20000; ++k) {
    const double linear = static_cast<double>(static_cast<float>(k / 20000.0));
    const double exact = 255.0 * SrgbFromLinear(linear);
    EXPECT_NEAR(SrgbByteFromLinear(static_cast<float>(linear)), exact, 0.5 + 1e-4) << k;
  }
  for (int byte = 0; byte < 256; ++byte) {
    EXPECT_EQ(SrgbByteFromLinear(static_cast<float>(LinearFromSrgb(byte / 255.0))), byte);
  }
}

TEST(Colour, ReadsHexadecimalColours) {
  const Result<LinearRgb> tortoise = ParseHexColour("#FF8000");
  ASSERT_TRUE(tortoise.has_value());
  EXPECT_FLOAT_EQ((*tortoise)[0], 1.0F);
  EXPECT_NEAR((*tortoise)[1], 0.21586050011389926, 1e-7);  // lin(128/255) of the script above
  EXPECT_FLOAT_EQ((*tortoise)[2], 0.0F);
  EXPECT_TRUE(ParseHexColour("0a0b0c").has_value());
  for (const char* wrong : {"", "#", "#12345", "#1234567", "#12345g", "0x1234", "-12345", " 12345", "rot"}) {
    EXPECT_FALSE(ParseHexColour(wrong).has_value()) << wrong;
  }
}

/// Relative luminance, IEC 61966-2-1.
double Luminance(const LinearRgb& rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

TEST(ColourMap, SequentialLightnessRisesEvenly) {
  double before = -1.0;
  for (int k = 0; k <= 100; ++k) {
    const double lightness = 116.0 * std::cbrt(Luminance(MapColour(ColourMap::kSequential, k / 100.0))) - 16.0;
    EXPECT_GT(lightness, before) << k;
    EXPECT_NEAR(lightness, 16.0 + 0.78 * k, 2.5) << k;
    before = lightness;
  }
}

TEST(ColourMap, DivergingIsEquallyLightOnBothSidesAndNeutralInTheMiddle) {
  for (int k = 0; k <= 50; ++k) {
    const double below = Luminance(MapColour(ColourMap::kDiverging, 0.5 - k / 100.0));
    const double above = Luminance(MapColour(ColourMap::kDiverging, 0.5 + k / 100.0));
    EXPECT_NEAR(below, above, 0.01) << k;
  }
  const LinearRgb middle = MapColour(ColourMap::kDiverging, 0.5);
  EXPECT_NEAR(middle[0], middle[2], 0.01);
  EXPECT_GT(MapColour(ColourMap::kDiverging, 1.0)[0], MapColour(ColourMap::kDiverging, 1.0)[2]);
  EXPECT_LT(MapColour(ColourMap::kDiverging, 0.0)[0], MapColour(ColourMap::kDiverging, 0.0)[2]);
}

TEST(ColourMap, ClampsAndMarksMissingValues) {
  EXPECT_EQ(MapColour(ColourMap::kSequential, -3.0), MapColour(ColourMap::kSequential, 0.0));
  EXPECT_EQ(MapColour(ColourMap::kSequential, 9.0), MapColour(ColourMap::kSequential, 1.0));
  EXPECT_EQ(MapColour(ColourMap::kDiverging, std::nan("")), kNoDataColour);
}

}  // namespace
}  // namespace annulus
