#include "base/units.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace annulus {
namespace {

static_assert(!std::is_convertible_v<double, Millimetres>, "a bare number is not a length");
static_assert(!std::is_convertible_v<Millimetres, Radians>, "a length is not an angle");
static_assert(!std::is_constructible_v<Millimetres, Radians>, "not even when asked");
static_assert(std::is_trivially_copyable_v<Millimetres> && sizeof(Millimetres) == sizeof(double));

TEST(Quantity, AddsSubtractsAndScalesWithinOneUnit) {
  constexpr Millimetres a(3.0);
  constexpr Millimetres b(1.5);
  static_assert((a + b).value() == 4.5);
  static_assert((a - b).value() == 1.5);
  static_assert((-a).value() == -3.0);
  static_assert((a * 2.0).value() == 6.0);
  static_assert((a / 2.0).value() == 1.5);
  EXPECT_EQ((a + b).value(), 4.5);
}

TEST(Quantity, DividedByItsOwnUnitIsANumber) {
  static_assert(std::is_same_v<decltype(Seconds(3.0) / Seconds(2.0)), double>);
  EXPECT_EQ(Seconds(3.0) / Seconds(2.0), 1.5);
}

TEST(Quantity, ComparesByValue) {
  EXPECT_LT(Hertz(1.0), Hertz(2.0));
  EXPECT_EQ(Hertz(2.0), Hertz(2.0));
  EXPECT_EQ(Millimetres(), Millimetres(0.0));
}

TEST(Degrees, TurnIntoRadiansAndBack) {
  EXPECT_DOUBLE_EQ(RadiansFromDegrees(180.0), kPi);
  EXPECT_DOUBLE_EQ(DegreesFromRadians(kPi / 2.0), 90.0);
  EXPECT_DOUBLE_EQ(DegreesFromRadians(RadiansFromDegrees(-37.5)), -37.5);
}

}  // namespace
}  // namespace annulus
