#include "modeling/glasses/lens_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "modeling/glasses/lens_form.h"
#include "tests/modeling_lens/ray_bundle.h"
#include "tests/modeling_lens/reference_lens.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

LensOrder Sphere(double power) { return {power * PowerMatrix::Identity(), Eigen::Vector2d::Zero()}; }

LensPose Tilted(double degrees) { return PoseOf(RadiansFromDegrees(degrees), 0.0, 12.0, Eye::kRight); }

struct Expected {
  double left_deg, up_deg;
  double prism_x, prism_y;
  double xx, xy, yy;
};

TEST(LensTrace, AgreesWithA40DigitBundleOfRays) {
  // lens_reference.py: a tilted torus behind a sphere, pantoscopic 10°, face form 6°, three directions of gaze.
  const Expected cases[] = {
      {0, 0, -2.08371033499255, -0.853401788142391, -5.59301200823345, -1.19603896419798, -4.39105714544419},
      {15, -20, 0.490291232494525, -3.86375898448379, -5.68170712403299, -1.160619909167, -4.2512220410655},
      {-25, 10, -7.77889792885373, 0.433113252801611, -5.29567609741427, -0.982144001173437, -4.26776913228142}};
  const LensPose pose = PoseOf(RadiansFromDegrees(10.0), RadiansFromDegrees(6.0), 13.0, Eye::kRight);
  for (const Expected& expected : cases) {
    const Gaze gaze{RadiansFromDegrees(expected.left_deg), RadiansFromDegrees(expected.up_deg)};
    const auto traced = TraceAsWorn(test::ReferenceLens(), pose, gaze);
    ASSERT_TRUE(traced);
    EXPECT_NEAR(traced->prism.x(), expected.prism_x, 1e-9);
    EXPECT_NEAR(traced->prism.y(), expected.prism_y, 1e-9);
    EXPECT_NEAR(traced->power(0, 0), expected.xx, 1e-9);
    EXPECT_NEAR(traced->power(0, 1), expected.xy, 1e-9);
    EXPECT_NEAR(traced->power(1, 0), expected.xy, 1e-9);
    EXPECT_NEAR(traced->power(1, 1), expected.yy, 1e-9);
  }
}

TEST(LensTrace, ParaxiallyItIsTheThickLensFormula) {
  // F1 + F2 from the front and the back; Fv = F1 / (1 − F1·t/n) + F2.
  for (const double base : {0.0, 4.0, 9.0}) {
    for (const double power : {-12.0, -4.0, 0.0, 5.0, 11.0}) {
      LensFormSpec spec;
      spec.base = base;
      spec.index = 1.6;
      spec.model = PowerModel::kThinSum;
      const double thickness = 5.0;
      const auto form = BuildLensForm(spec, Sphere(power), thickness);
      ASSERT_TRUE(form);
      const double expected = base / (1.0 - base * thickness / 1600.0) + (power - base);
      const auto worn = TraceAsWorn(*form, Tilted(0.0));
      const auto focimeter = TraceFocimeter(*form);
      ASSERT_TRUE(worn && focimeter);
      EXPECT_NEAR((worn->power - expected * PowerMatrix::Identity()).norm(), 0.0, 1e-9);
      EXPECT_NEAR((focimeter->power - expected * PowerMatrix::Identity()).norm(), 0.0, 1e-9);
      EXPECT_NEAR(worn->prism.norm(), 0.0, 1e-9);
    }
  }
}

TEST(LensTrace, ATiltedLensFollowsMartinsFormula) {
  // The formula is that of a thin lens: a thin lens with a flat base comes close to it, within 0.02 D for small tilts.
  for (const double index : {1.498, 1.586, 1.67, 1.74}) {
    for (const double power : {-6.0, -4.0, -2.0, 2.0, 4.0}) {
      for (const double degrees : {2.0, 5.0, 8.0}) {
        LensFormSpec spec;
        spec.base = power > 0 ? power + 6.0 : power / 2.0 + 6.0;
        spec.index = index;
        const auto form = BuildLensForm(spec, Sphere(power), 1.0);
        ASSERT_TRUE(form);
        const auto worn = TraceAsWorn(*form, Tilted(degrees));
        ASSERT_TRUE(worn);
        const PowerMatrix martin =
            MartinTilted(Sphere(power).power, index, CombinedTilt(RadiansFromDegrees(degrees), 0.0, Eye::kRight));
        EXPECT_LE(WorstMeridian(worn->power - martin), 0.02) << index << " " << power << " " << degrees;
      }
    }
  }
}

TEST(LensTrace, FifteenDegreesOnMinusFourAreMartinsFigures) {
  LensFormSpec spec;
  spec.base = 4.0;
  spec.index = 1.498;
  const auto form = BuildLensForm(spec, Sphere(-4.0), 2.0);
  ASSERT_TRUE(form);
  const auto worn = TraceAsWorn(*form, Tilted(15.0));
  ASSERT_TRUE(worn);
  const SpheroCylinder power = SpheroCylinderFrom(worn->power);
  EXPECT_NEAR(power.sphere + 4.0, -0.09, 0.02);
  EXPECT_NEAR(power.cylinder, -0.29, 0.02);
  EXPECT_NEAR(power.axis, kPi, 1e-6);
}

TEST(LensTrace, AgreesWithABundleOfRaysForRandomLensesAndTilts) {
  test::Dice dice(21);
  int compared = 0;
  for (int i = 0; i < 1000; ++i) {
    LensFormSpec spec;
    spec.base = dice.Between(0.0, 9.0);
    spec.index = dice.Between(1.49, 1.75);
    spec.reference = {dice.Between(-5, 5), dice.Between(-5, 5)};
    const LensOrder order{MatrixFrom({dice.Between(-10, 8), -dice.Between(0, 4), dice.Between(0.01, kPi)}),
                          {dice.Between(-5, 5), dice.Between(-5, 5)}};
    const auto form = BuildLensForm(spec, order, dice.Between(1.0, 8.0));
    ASSERT_TRUE(form);
    const double pantoscopic = dice.Between(-0.2, 0.4);
    const double face_form = dice.Between(-0.1, 0.4);
    const LensPose pose = PoseOf(pantoscopic, face_form, 12.0, Eye::kLeft);
    const auto traced = TraceAsWorn(*form, pose);
    const auto bundle = test::BundlePower(*form, pose);
    ASSERT_TRUE(traced && bundle);
    // The bundle's own error: (h · curvature)² of the power, h = 0.01 mm.
    ASSERT_LE((traced->power - *bundle).cwiseAbs().maxCoeff(), 1e-5);
    ASSERT_NEAR(traced->power(0, 1), traced->power(1, 0), 1e-9);
    ++compared;
  }
  EXPECT_EQ(compared, 1000);
}

TEST(LensTrace, ARayBesideTheOpticalCentreFollowsPrentice) {
  // Rays parallel to the axis, h mm beside it. Prentice is paraxial: the bound is 0.02 cm/m + 8 % up to 10 mm.
  for (const double power : {-8.0, -4.0, -1.0, 2.0, 5.0}) {
    LensFormSpec spec;
    spec.base = power > 0 ? power + 6.0 : power / 2.0 + 6.0;
    spec.index = 1.6;
    const LensOrder order{MatrixFrom({power, -1.0, 0.5}), Eigen::Vector2d::Zero()};
    const auto form = BuildLensForm(spec, order, power > 0 ? 4.0 : 1.5);
    ASSERT_TRUE(form);
    for (const double h : {1.0, 3.0, 6.0, 10.0}) {
      for (int eighth = 0; eighth < 8; ++eighth) {
        const double around = kTwoPi * eighth / 8.0;
        const Eigen::Vector2d offset(h * std::cos(around), h * std::sin(around));
        const auto ray =
            test::Through(*form, form->front, form->back, {{offset.x(), offset.y(), 5.0}, -Eigen::Vector3d::UnitZ()});
        ASSERT_TRUE(ray);
        const Eigen::Vector2d prism = 100.0 * ray->direction.head<2>() / -ray->direction.z();
        const Eigen::Vector2d prentice = PrenticePrism(order.power, offset);
        EXPECT_LE((prism - prentice).norm(), 0.02 + 0.08 * prentice.norm()) << power << " " << h;
      }
    }
  }
}

TEST(LensTrace, LookingAsideThroughALensMeetsPrenticesPrism) {
  // The eye turns by 10°: 25 mm·tan 10° = 4.4 mm beside the centre of a −4 D lens: 1.76 cm/m, base towards the gaze.
  LensFormSpec spec;
  spec.base = 4.0;
  spec.index = 1.6;
  const auto form = BuildLensForm(spec, Sphere(-4.0), 2.0);
  const auto traced = TraceAsWorn(*form, Tilted(0.0), {0.0, RadiansFromDegrees(10.0)});
  ASSERT_TRUE(traced);
  // Prentice is about slopes: tan of the angle before less that behind.
  const double behind = RadiansFromDegrees(10.0);
  const double slopes = std::tan(behind + std::atan(traced->prism.y() / 100.0)) - std::tan(behind);
  const double prentice = 0.4 * 25.0 * std::tan(behind);
  EXPECT_NEAR(100.0 * slopes, prentice, 0.03 * prentice);
  EXPECT_NEAR(traced->prism.x(), 0.0, 1e-9);
}

TEST(LensTrace, AMissedSurfaceIsAnErrorNotACrash) {
  LensFormSpec spec;
  spec.base = 4.0;
  spec.index = 1.5;
  // A back that bulges towards the eye by a radius of about 31 mm: lines steeper than asin(31/56) miss it.
  const auto form = BuildLensForm(spec, Sphere(20.0), 1.0);
  ASSERT_TRUE(form);
  const auto traced = TraceAsWorn(*form, Tilted(0.0), {RadiansFromDegrees(50.0), 0.0});
  ASSERT_FALSE(traced);
  EXPECT_THAT(traced.error().Text(), testing::HasSubstr("trace a ray through the lens"));
}

TEST(LensTrace, TheEyesAreMirrorImages) {
  LensFormSpec spec;
  spec.base = 5.0;
  spec.index = 1.6;
  const auto right = BuildLensForm(spec, {MatrixFrom({-3.0, -1.5, 0.7}), {1.0, 2.0}}, 2.0);
  const auto left = BuildLensForm(spec, {MatrixFrom({-3.0, -1.5, kPi - 0.7}), {-1.0, 2.0}}, 2.0);
  ASSERT_TRUE(right && left);
  const auto from_right = TraceAsWorn(*right, PoseOf(0.15, 0.1, 12.0, Eye::kRight));
  const auto from_left = TraceAsWorn(*left, PoseOf(0.15, 0.1, 12.0, Eye::kLeft));
  ASSERT_TRUE(from_right && from_left);
  EXPECT_NEAR(from_right->power(0, 0), from_left->power(0, 0), 1e-9);
  EXPECT_NEAR(from_right->power(0, 1), -from_left->power(0, 1), 1e-9);
  EXPECT_NEAR(from_right->power(1, 1), from_left->power(1, 1), 1e-9);
  EXPECT_NEAR(from_right->prism.x(), -from_left->prism.x(), 1e-9);
  EXPECT_NEAR(from_right->prism.y(), from_left->prism.y(), 1e-9);
}

}  // namespace
}  // namespace annulus
