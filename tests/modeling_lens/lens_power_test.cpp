#include "modeling/glasses/lens_power.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

PowerMatrix Sphere(double power) { return power * PowerMatrix::Identity(); }

TEST(LensPower, AMatrixShowsThePowerOfItsMeridians) {
  // −2.00 −1.00 × 90: −3.00 D across, −2.00 D upright.
  const PowerMatrix matrix = MatrixFrom({-2.0, -1.0, kPi / 2.0});
  EXPECT_NEAR(matrix(0, 0), -3.0, 1e-12);
  EXPECT_NEAR(matrix(1, 1), -2.0, 1e-12);
  EXPECT_NEAR(matrix(0, 1), 0.0, 1e-12);
  // A cylinder at 45° has its power along 135°: uᵀFu there.
  const PowerMatrix oblique = MatrixFrom({0.0, -1.0, kPi / 4.0});
  const Eigen::Vector2d along_135(-std::sqrt(0.5), std::sqrt(0.5));
  EXPECT_NEAR(along_135.dot(oblique * along_135), -1.0, 1e-12);
}

TEST(LensPower, MatrixAndSpheroCylinderAreInverse) {
  test::Dice dice(1);
  for (int i = 0; i < 10000; ++i) {
    const SpheroCylinder power{dice.Between(-20, 20), -dice.Between(0.01, 10), dice.Between(0.001, kPi)};
    const SpheroCylinder again = SpheroCylinderFrom(MatrixFrom(power));
    EXPECT_NEAR(again.sphere, power.sphere, 1e-9);
    EXPECT_NEAR(again.cylinder, power.cylinder, 1e-9);
    EXPECT_NEAR(again.axis, power.axis, 1e-9);
  }
  EXPECT_EQ(SpheroCylinderFrom(Sphere(3.0)).cylinder, 0.0);
  EXPECT_EQ(SpheroCylinderFrom(Sphere(3.0)).axis, kPi);
}

TEST(LensPower, TenDioptresAtTwelveMillimetresAre893AtTheCornea) {
  const auto cornea = AtVertexDistance(Sphere(-10.0), 12.0, 0.0);
  ASSERT_TRUE(cornea);
  EXPECT_NEAR((*cornea)(0, 0), -8.93, 0.005);
  EXPECT_NEAR((*cornea)(0, 0), -10.0 / 1.12, 1e-12);
  const auto back = AtVertexDistance(*cornea, 0.0, 12.0);
  EXPECT_NEAR(((*back) - Sphere(-10.0)).norm(), 0.0, 1e-12);
}

TEST(LensPower, VertexDistanceActsOnEachPrincipalMeridian) {
  const auto moved = AtVertexDistance(MatrixFrom({8.0, -3.0, 0.6}), 14.0, 10.0);
  ASSERT_TRUE(moved);
  const SpheroCylinder power = SpheroCylinderFrom(*moved);
  const double strong = 8.0 / (1.0 - 0.004 * 8.0);
  const double weak = 5.0 / (1.0 - 0.004 * 5.0);
  EXPECT_NEAR(power.sphere, strong, 1e-12);
  EXPECT_NEAR(power.cylinder, weak - strong, 1e-12);
  EXPECT_NEAR(power.axis, 0.6, 1e-12);
}

TEST(LensPower, LightThatFocusesBeforeTheCorneaIsRefused) {
  EXPECT_TRUE(AtVertexDistance(Sphere(30.0), 30.0, 0.0));
  const auto moved = AtVertexDistance(Sphere(40.0), 25.0, 0.0);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().Text(), testing::HasSubstr("comes to a focus"));
}

TEST(LensPower, FifteenDegreesOnMinusFourGiveMartinsFigures) {
  // Pantoscopic: the tilt axis is horizontal. −4·sin²15°/(2·1.5) = −0.0893; tan²15° = 0.0718.
  const LensTilt tilt = CombinedTilt(RadiansFromDegrees(15.0), 0.0, Eye::kRight);
  EXPECT_NEAR(tilt.angle, RadiansFromDegrees(15.0), 1e-12);
  const SpheroCylinder power = SpheroCylinderFrom(MartinTilted(Sphere(-4.0), 1.5, tilt));
  EXPECT_NEAR(power.sphere - -4.0, -0.09, 0.005);
  EXPECT_NEAR(power.cylinder, -0.29, 0.005);
  EXPECT_NEAR(power.axis, kPi, 1e-9);
  for (const double index : {1.498, 1.586, 1.67, 1.74}) {
    const SpheroCylinder other = SpheroCylinderFrom(MartinTilted(Sphere(-4.0), index, tilt));
    EXPECT_NEAR(other.sphere + 4.0, -0.09, 0.015) << index;
    EXPECT_NEAR(other.cylinder, -0.29, 0.005) << index;
  }
}

TEST(LensPower, FaceFormTiltsAboutTheVertical) {
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const LensTilt tilt = CombinedTilt(0.0, RadiansFromDegrees(10.0), eye);
    EXPECT_NEAR(tilt.angle, RadiansFromDegrees(10.0), 1e-12);
    EXPECT_NEAR(tilt.axis, kPi / 2.0, 1e-12);
  }
}

TEST(LensPower, BothTiltsAreOneObliqueTiltMirroredBetweenTheEyes) {
  const double pantoscopic = RadiansFromDegrees(9.0);
  const double face_form = RadiansFromDegrees(9.0);
  const LensTilt right = CombinedTilt(pantoscopic, face_form, Eye::kRight);
  const LensTilt left = CombinedTilt(pantoscopic, face_form, Eye::kLeft);
  // The normal's angle: cos θ = cos 9° · cos 9°.
  EXPECT_NEAR(std::cos(right.angle), std::pow(std::cos(pantoscopic), 2), 1e-12);
  EXPECT_NEAR(left.angle, right.angle, 1e-12);
  EXPECT_NEAR(left.axis, kPi - right.axis, 1e-12);
  // The right lens looks down and to the viewer's left (its temple), so its tilt axis runs from the upper left to the
  // lower right: about 135°.
  EXPECT_NEAR(DegreesFromRadians(right.axis), 135.0, 0.5);
}

TEST(LensPower, AnObliqueTiltTurnsWithTheAxis) {
  const PowerMatrix upright = MartinTilted(Sphere(5.0), 1.6, {0.2, 0.0});
  const SpheroCylinder turned = SpheroCylinderFrom(MartinTilted(Sphere(5.0), 1.6, {0.2, 1.0}));
  EXPECT_NEAR(turned.sphere, upright(1, 1), 1e-12);
  EXPECT_NEAR(turned.sphere + turned.cylinder, upright(0, 0), 1e-12);
  EXPECT_NEAR(turned.axis, 1.0 + kPi / 2.0, 1e-12);  // plus: in minus form the axis is across
}

TEST(LensPower, WorstMeridianOfADifference) {
  EXPECT_NEAR(WorstMeridian(MatrixFrom({0.1, -0.3, 0.4})), 0.2, 1e-12);
  EXPECT_NEAR(WorstMeridian(MatrixFrom({0.1, -0.15, 0.4})), 0.1, 1e-12);
  EXPECT_NEAR(SphericalEquivalent(MatrixFrom({-4.0, -1.0, 0.3})), -4.5, 1e-12);
}

TEST(LensPower, PrenticesRuleGivesTheTextbookPrisms) {
  // −4 D, looked through 5 mm above the centre: base up 2 cm/m. +4 D: base down.
  EXPECT_NEAR(PrenticePrism(Sphere(-4.0), {0.0, 5.0}).y(), 2.0, 1e-12);
  EXPECT_NEAR(PrenticePrism(Sphere(4.0), {0.0, 5.0}).y(), -2.0, 1e-12);
  // A cylinder at 45° deflects across its axis: offset to the right gives a vertical share as well.
  const Eigen::Vector2d oblique = PrenticePrism(MatrixFrom({0.0, -2.0, kPi / 4.0}), {10.0, 0.0});
  EXPECT_NEAR(oblique.x(), 1.0, 1e-12);
  EXPECT_NEAR(oblique.y(), -1.0, 1e-12);
}

}  // namespace
}  // namespace annulus
