#include "base/frames.h"

#include <gtest/gtest.h>

#include <random>

namespace annulus {
namespace {

TEST(WrapAngle, LeavesAnglesOfOneTurnAsTheyAre) {
  EXPECT_EQ(WrapAngle(0.0), 0.0);
  EXPECT_EQ(WrapAngle(1.25), 1.25);
  EXPECT_EQ(WrapAngle(std::nextafter(kTwoPi, 0.0)), std::nextafter(kTwoPi, 0.0));
}

TEST(WrapAngle, TakesAWholeTurnToZero) {
  EXPECT_EQ(WrapAngle(kTwoPi), 0.0);
  EXPECT_EQ(WrapAngle(-kTwoPi), 0.0);
  EXPECT_EQ(WrapAngle(-0.0), 0.0);
}

TEST(WrapAngle, NeverReturnsAWholeTurnForATinyNegativeAngle) {
  for (const double tiny : {-1e-18, -5e-324, -1e-16, -1e-15}) {
    const double wrapped = WrapAngle(tiny);
    EXPECT_GE(wrapped, 0.0) << tiny;
    EXPECT_LT(wrapped, kTwoPi) << tiny;
  }
}

TEST(WrapAngle, KeepsDirectionForLargeAngles) {
  // Exactly representable multiples are not at hand; the direction must agree with sin and cos of the C library.
  for (const double angle : {1e3, -1e3, 1e6 + 0.25, -1e6 - 0.25}) {
    const double wrapped = WrapAngle(angle);
    EXPECT_GE(wrapped, 0.0);
    EXPECT_LT(wrapped, kTwoPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-9) << angle;
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-9) << angle;
  }
  EXPECT_LT(WrapAngle(1e308), kTwoPi);
  EXPECT_GE(WrapAngle(-1e308), 0.0);
}

TEST(AngleDifference, IsTheShortWayRound) {
  EXPECT_NEAR(AngleDifference(0.1, kTwoPi - 0.1), 0.2, 1e-15);
  EXPECT_NEAR(AngleDifference(kTwoPi - 0.1, 0.1), -0.2, 1e-15);
  EXPECT_EQ(AngleDifference(2.0, 2.0), 0.0);
}

TEST(AngleDifference, LiesInTheHalfOpenTurnWhateverTheAngles) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 10'000; ++k) {
    const double a = 40.0 * (static_cast<double>(random() >> 11U) * 0x1p-53 - 0.5);
    const double b = 40.0 * (static_cast<double>(random() >> 11U) * 0x1p-53 - 0.5);
    const double difference = AngleDifference(a, b);
    ASSERT_GE(difference, -kPi);
    ASSERT_LT(difference, kPi);
    ASSERT_NEAR(std::remainder(difference - (a - b), kTwoPi), 0.0, 1e-12);
  }
}

TEST(PointFromCylindrical, PutsTheSubjectsFrontOnPlusY) {
  const Eigen::Vector3d front = PointFromCylindrical(RadiansFromDegrees(90.0), 200.0, 1500.0);
  EXPECT_NEAR(front.x(), 0.0, 1e-12);
  EXPECT_NEAR(front.y(), 200.0, 1e-12);
  EXPECT_EQ(front.z(), 1500.0);
  EXPECT_EQ(PointFromCylindrical(0.0, 200.0, 0.0), Eigen::Vector3d(200.0, 0.0, 0.0));
}

}  // namespace
}  // namespace annulus
