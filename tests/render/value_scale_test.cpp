#include "render/value_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace annulus {
namespace {

/// What an 8-bit picture keeps of a colour.
LinearRgb InBytes(const LinearRgb& colour) {
  LinearRgb kept;
  for (Eigen::Index k = 0; k < 3; ++k) {
    kept[k] = static_cast<float>(LinearFromSrgb(SrgbByteFromLinear(colour[k]) / 255.0));
  }
  return kept;
}

std::vector<WeightedValue> Of(std::initializer_list<double> values) {
  std::vector<WeightedValue> weighted;
  for (const double value : values) weighted.push_back({value, 1.0});
  return weighted;
}

TEST(ValueScale, AColourOfAnEightBitPictureIsReadBackToOnePercentUnderAnyLight) {
  for (const ColourMap map : {ColourMap::kDiverging, ColourMap::kSequential}) {
    const ValueScale scale{map, -3.0, 5.0};
    for (int k = 0; k <= 160; ++k) {
      const double value = -3.0 + 8.0 * k / 160.0;
      for (const float shade : {kMapShade, 0.9F, 0.95F, 1.0F}) {
        EXPECT_NEAR(scale.ValueOf(InBytes(shade * scale.ColourOf(value))), value, 0.01 * 8.0) << value << " " << shade;
      }
    }
  }
}

TEST(ValueScale, WhatLiesBeyondAnEndHasItsColourUnlessItMeansSomethingElse) {
  ValueScale scale{ColourMap::kSequential, 0.0, 10.0};
  EXPECT_EQ(scale.ColourOf(-1.0), scale.ColourOf(0.0));
  EXPECT_EQ(scale.ColourOf(12.0), scale.ColourOf(10.0));
  EXPECT_EQ(scale.ColourOf(std::numeric_limits<double>::quiet_NaN()), kNoDataColour);
  scale.under = LinearRgb(1.0F, 0.0F, 0.0F);
  EXPECT_EQ(scale.ColourOf(-1e-9), LinearRgb(1.0F, 0.0F, 0.0F));
  EXPECT_NE(scale.ColourOf(0.0), LinearRgb(1.0F, 0.0F, 0.0F));
}

TEST(ValueRange, AboutZeroHoldsNinetyEightPercentOfTheAmounts) {
  // 0.01, 0.02 … 1.00 with changing signs: 98 of them do not exceed 0.98, which a scale rounds to 1.
  std::vector<WeightedValue> values;
  for (int k = 1; k <= 100; ++k) values.push_back({(k % 2 == 0 ? 0.01 : -0.01) * k, 1.0});
  const ValueRange range = RangeByRule(values, ScaleRule::kAboutZero);
  EXPECT_DOUBLE_EQ(range.minimum, -1.0);
  EXPECT_DOUBLE_EQ(range.maximum, 1.0);
  EXPECT_DOUBLE_EQ(range.least, -0.99);
  EXPECT_DOUBLE_EQ(range.greatest, 1.0);
  EXPECT_NEAR(range.mean, 0.005, 1e-12);                              // 50 pairs of 0.01
  EXPECT_NEAR(range.rms, std::sqrt(1e-4 * 338350.0 / 100.0), 1e-12);  // sum of squares up to 100
  EXPECT_DOUBLE_EQ(range.above + range.below, 0.0);
}

TEST(ValueRange, SharesBeyondTheEndsAreThoseOfTheWeights) {
  const std::vector<WeightedValue> values{{-5.0, 1.0}, {0.0, 6.0}, {2.0, 2.0}, {9.0, 1.0}};
  const ValueRange range = RangeGiven(values, -1.0, 2.0);
  EXPECT_DOUBLE_EQ(range.below, 0.1);
  EXPECT_DOUBLE_EQ(range.above, 0.1);
  EXPECT_DOUBLE_EQ(range.weight, 10.0);
  EXPECT_DOUBLE_EQ(range.mean, 0.8);
}

TEST(ValueRange, PercentilesLeaveOutlinersBeyondTheEnds) {
  std::vector<WeightedValue> values;
  for (int k = 0; k < 1000; ++k) values.push_back({20.0 + 0.01 * k, 1.0});
  values.push_back({-1e6, 1.0});
  values.push_back({1e6, 1.0});
  const ValueRange range = RangeByRule(values, ScaleRule::kPercentiles);
  EXPECT_NEAR(range.minimum, 20.2, 1.0);
  EXPECT_NEAR(range.maximum, 29.8, 1.0);
  EXPECT_LE(range.minimum, 20.2);
  EXPECT_GE(range.maximum, 29.79);
}

TEST(ValueRange, IsAProperScaleForValuesThatAreAllAlikeAndForNone) {
  for (const ScaleRule rule : {ScaleRule::kAboutZero, ScaleRule::kFromZero, ScaleRule::kPercentiles}) {
    for (const double value : {0.0, 7.0, -0.001}) {
      const ValueRange range = RangeByRule(Of({value, value, value}), rule);
      EXPECT_LT(range.minimum, range.maximum);
      if (rule != ScaleRule::kFromZero) {
        EXPECT_LE(range.minimum, value);
      }
      EXPECT_GE(range.maximum, value);
    }
    const ValueRange none = RangeByRule(Of({std::numeric_limits<double>::quiet_NaN()}), rule);
    EXPECT_DOUBLE_EQ(none.weight, 0.0);
    EXPECT_LT(none.minimum, none.maximum);
  }
}

}  // namespace
}  // namespace annulus
