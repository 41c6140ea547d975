#include "station/units_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace annulus {
namespace {

Measurement Of(double value, double sigma, const std::string& unit) {
  Measurement m;
  m.unit = unit;
  m.value = {value, sigma};
  return m;
}

TEST(UnitsText, InchesAreRoundedToEighthsAndReduced) {
  EXPECT_EQ(InchEighthsText(25.4), "1");
  EXPECT_EQ(InchEighthsText(33.375 * 25.4), "33 3/8");
  EXPECT_EQ(InchEighthsText(33.5 * 25.4), "33 1/2");
  EXPECT_EQ(InchEighthsText(33.75 * 25.4), "33 3/4");
  EXPECT_EQ(InchEighthsText(0.125 * 25.4), "1/8");
  EXPECT_EQ(InchEighthsText(0.0), "0");
  EXPECT_EQ(InchEighthsText(9.95 * 25.4), "10");  // 79.6 eighths
  EXPECT_EQ(InchEighthsText(-2.25 * 25.4), "-2 1/4");
  EXPECT_EQ(InchEighthsText(-0.2), "0");
}

TEST(UnitsText, ALengthIsReadInTheCustomersUnit) {
  const Measurement girth = Of(846.24, 0.5, "mm");
  const ValueText mm = DescribeValue(girth, LengthUnit::kMillimetre);
  EXPECT_EQ(mm.value + " " + mm.unit + " " + mm.half95, "846.2 mm 1.0");
  const ValueText cm = DescribeValue(girth, LengthUnit::kCentimetre);
  EXPECT_EQ(cm.value + " " + cm.unit + " " + cm.half95, "84.6 cm 0.10");
  const ValueText inch = DescribeValue(girth, LengthUnit::kInch);
  EXPECT_EQ(inch.value + " " + inch.unit + " " + inch.half95, "33 3/8 in 0.04");  // 33.317 in, 0.0386 in
}

TEST(UnitsText, AreasVolumesAndAnglesHaveUnitsOfTheirOwn) {
  EXPECT_EQ(DescribeValue(Of(4.25e7, 1e4, "mm3"), LengthUnit::kCentimetre).value, "42.50");
  EXPECT_EQ(DescribeValue(Of(4.25e7, 1e4, "mm3"), LengthUnit::kCentimetre).unit, "L");
  EXPECT_EQ(DescribeValue(Of(16387.064, 1, "mm3"), LengthUnit::kInch).value, "1");  // 25.4³
  EXPECT_EQ(DescribeValue(Of(12345, 10, "mm2"), LengthUnit::kMillimetre).value, "123.5");
  EXPECT_EQ(DescribeValue(Of(645.16, 10, "mm2"), LengthUnit::kInch).value, "1.0");
  EXPECT_EQ(DescribeValue(Of(21.54, 1, "deg"), LengthUnit::kInch).value, "21.5");
  EXPECT_EQ(DescribeValue(Of(21.54, 1, "deg"), LengthUnit::kInch).half95, "2.0");
}

TEST(UnitsText, AnIntervalIsRoundedUpAndNeverShownAsNothing) {
  EXPECT_EQ(DescribeValue(Of(100, 0.001, "mm"), LengthUnit::kMillimetre).half95, "0.1");
  EXPECT_EQ(DescribeValue(Of(100, 0.0, "mm"), LengthUnit::kMillimetre).half95, "0.0");
}

TEST(UnitsText, WhatIsNotKnownIsADash) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(DescribeValue(Of(100, nan, "mm"), LengthUnit::kInch).half95, "–");
  EXPECT_EQ(DescribeValue(Of(nan, nan, "mm"), LengthUnit::kInch).value, "–");
}

TEST(UnitsText, UnitsAreGivenByName) {
  EXPECT_EQ(LengthUnitFromName("inch"), LengthUnit::kInch);
  EXPECT_EQ(LengthUnitFromName("cm"), LengthUnit::kCentimetre);
  EXPECT_EQ(LengthUnitFromName("mm"), LengthUnit::kMillimetre);
  EXPECT_FALSE(LengthUnitFromName("ell").has_value());
}

}  // namespace
}  // namespace annulus
