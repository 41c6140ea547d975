#include "modeling/glasses/lens_form.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "modeling/glasses/lens_thickness.h"
#include "tests/modeling_lens/lens_shapes.h"
#include "tests/modeling_lens/ray_bundle.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using test::Ellipse;

LensOrder Sphere(double power) { return {power * PowerMatrix::Identity(), Eigen::Vector2d::Zero()}; }

LensFormSpec Spec(double base, double index, PowerModel model = PowerModel::kBackVertex) {
  LensFormSpec spec;
  spec.base = base;
  spec.index = index;
  spec.model = model;
  return spec;
}

TEST(LensForm, MinusFourHasTheKnownEdgeByTheThinSum) {
  // R1 = 1000(n − 1)/4, R2 = 1000(n − 1)/8, exact sags at 29 mm, 2 mm in the middle (issue 8).
  const double expected[4][2] = {{1.498, 5.74}, {1.586, 5.09}, {1.67, 4.65}, {1.74, 4.38}};
  for (const auto& [index, edge] : expected) {
    const auto form =
        ThinnestLensForm(Spec(4.0, index, PowerModel::kThinSum), Sphere(-4.0), Ellipse(58.0, 58.0), {2.0, 1.0, 25.0});
    ASSERT_TRUE(form) << form.error().Text();
    EXPECT_NEAR(form->centre_thickness, 2.0, 1e-9);
    EXPECT_NEAR(1.0 / form->front.curvature_u, 1000.0 * (index - 1.0) / 4.0, 1e-9);
    EXPECT_NEAR(1.0 / form->back.curvature_u, 1000.0 * (index - 1.0) / 8.0, 1e-9);
    EXPECT_NEAR(form->Thickness(29.0, 0.0), edge, 0.01);
  }
}

TEST(LensForm, MinusFourHasTheKnownEdgeByTheBackVertexPower) {
  const double expected[4][2] = {{1.498, 5.77}, {1.586, 5.10}, {1.67, 4.67}, {1.74, 4.39}};
  for (const auto& [index, edge] : expected) {
    const auto form = ThinnestLensForm(Spec(4.0, index), Sphere(-4.0), Ellipse(58.0, 58.0), {2.0, 1.0, 25.0});
    ASSERT_TRUE(form) << form.error().Text();
    EXPECT_NEAR(form->Thickness(29.0, 0.0), edge, 0.01);
    // F2 = Fv − F1 / (1 − F1·t/n).
    const double back = -4.0 - 4.0 / (1.0 - 4.0 * 0.002 / index);
    EXPECT_NEAR(form->back.curvature_u, -back / (1000.0 * (index - 1.0)), 1e-12);
  }
}

TEST(LensForm, APlusLensGrowsInTheMiddleToAKnifeEdge) {
  // +5 D on a base of 11 D, n 1.6, round 50 mm: t − sag1 + sag2 = 1 at 25 mm.
  const auto form =
      ThinnestLensForm(Spec(11.0, 1.6, PowerModel::kThinSum), Sphere(5.0), Ellipse(50.0, 50.0), {1.5, 1.0, 25.0});
  ASSERT_TRUE(form);
  const auto sag = [](double radius) { return radius - std::sqrt(radius * radius - 625.0); };
  EXPECT_NEAR(form->centre_thickness, 1.0 + sag(600.0 / 11.0) - sag(600.0 / 6.0), 1e-8);
  EXPECT_NEAR(form->Thickness(0.0, 25.0), 1.0, 1e-8);
}

TEST(LensForm, ATorusShowsItsPowersInItsMeridians) {
  // −2.00 −3.00 × 30 on 4 D, thin: back −6 D along 30°, −9 D across. The steeper meridian (u) is at 120°.
  const auto form = BuildLensForm(Spec(4.0, 1.5, PowerModel::kThinSum),
                                  {MatrixFrom({-2.0, -3.0, kPi / 6.0}), Eigen::Vector2d::Zero()}, 2.0);
  ASSERT_TRUE(form);
  EXPECT_NEAR(form->back.curvature_u, 9.0 / 500.0, 1e-12);
  EXPECT_NEAR(form->back.curvature_v, 6.0 / 500.0, 1e-12);
  const auto sag = [](double radius, double x) { return radius - std::sqrt(radius * radius - x * x); };
  const double c = std::cos(kPi / 6.0);
  const double s = std::sin(kPi / 6.0);
  EXPECT_NEAR(form->Thickness(20.0 * c, 20.0 * s), 2.0 - sag(125.0, 20.0) + sag(500.0 / 6.0, 20.0), 1e-9);
  EXPECT_NEAR(form->Thickness(-20.0 * s, 20.0 * c), 2.0 - sag(125.0, 20.0) + sag(500.0 / 9.0, 20.0), 1e-9);
}

TEST(LensForm, TheFocimeterReadsTheOrderWithAnyPrismAndDecentration) {
  test::Dice dice(8);
  for (int i = 0; i < 500; ++i) {
    LensFormSpec spec = Spec(dice.Between(0.0, 9.0), dice.Between(1.49, 1.75));
    spec.box_centre = {1.0, 2.0};
    spec.reference = {dice.Between(-5.0, 7.0), dice.Between(-3.0, 7.0)};
    const LensOrder order{MatrixFrom({dice.Between(-10, 8), -dice.Between(0.0, 5), dice.Between(0.01, kPi)}),
                          {dice.Between(-8, 8), dice.Between(-8, 8)}};
    const auto form = BuildLensForm(spec, order, dice.Between(1.0, 8.0));
    ASSERT_TRUE(form);
    const auto read = TraceFocimeter(*form);
    ASSERT_TRUE(read);
    ASSERT_NEAR((read->power - order.power).cwiseAbs().maxCoeff(), 0.0, 1e-9);
    ASSERT_NEAR((read->prism - order.prism).norm(), 0.0, 1e-9);
  }
}

TEST(LensForm, APrismIsAWedgeOfThatAngle) {
  // Plano on a flat base: a plane wedge. tan δ = 0.05; n·sin A = sin(A + δ).
  const auto form = BuildLensForm(Spec(0.0, 1.5), {PowerMatrix::Zero(), {0.0, -5.0}}, 5.0);
  ASSERT_TRUE(form);
  const double delta = std::atan(0.05);
  const double wedge = std::atan2(form->Thickness(0.0, -10.0) - form->Thickness(0.0, 10.0), 20.0);
  EXPECT_GT(wedge, 0.0) << "base down: thicker below";
  EXPECT_NEAR(1.5 * std::sin(wedge), std::sin(wedge + delta), 1e-12);
  EXPECT_NEAR(wedge, delta / 0.5, 0.005) << "δ = (n − 1)·A";
}

TEST(LensForm, BothMinimaHoldOverTheOutlineAndOneOfThemIsTouched) {
  test::Dice dice(33);
  int made = 0;
  for (int i = 0; i < 300; ++i) {
    const ThicknessRule rule{dice.Between(1.0, 2.5), dice.Between(0.5, 2.0), 25.0};
    LensFormSpec spec = Spec(dice.Between(2.0, 7.0), 1.6);
    spec.reference = {dice.Between(-4, 4), dice.Between(-3, 3)};
    const LensOrder order{MatrixFrom({dice.Between(-8, 6), -dice.Between(0, 4), dice.Between(0.01, kPi)}),
                          {dice.Between(-3, 3), dice.Between(-3, 3)}};
    const double a = dice.Between(44, 54);
    const double b = dice.Between(30, 44);
    const LensOutline outline = Ellipse(a, b, 120);
    const auto form = ThinnestLensForm(spec, order, outline, rule);
    if (!form) continue;
    ++made;
    double edge = 1e9;
    double inner = 1e9;
    for (const Eigen::Vector2d& point : outline.points) {
      edge = std::min(edge, form->Thickness(point.x(), point.y()));
      for (int twentieth = 0; twentieth < 20; ++twentieth) {
        const double share = twentieth / 20.0;
        inner = std::min(inner, form->Thickness(share * point.x(), share * point.y()));
      }
    }
    EXPECT_GE(edge, rule.minimum_edge - 1e-8);
    EXPECT_GE(form->centre_thickness, rule.minimum_centre - 1e-8);
    EXPECT_GE(inner, std::min(rule.minimum_centre, rule.minimum_edge) - 1e-3);
    const auto extreme = InnerExtremeOf(*form, outline);
    double touch = std::min(edge - rule.minimum_edge, form->centre_thickness - rule.minimum_centre);
    if (extreme && extreme->minimum) {
      EXPECT_GE(inner, extreme->thickness - 1e-9) << "the inner extreme is the thinnest point";
      // minimum_centre from 5 mm inside on, evenly down (or up) to minimum_edge at the edge.
      double from_edge = 1e9;
      for (const Eigen::Vector2d& point : outline.points) {
        from_edge = std::min(from_edge, (point - extreme->position).norm());
      }
      const double share = std::min(1.0, from_edge / 5.0);
      const double required = rule.minimum_edge + share * (rule.minimum_centre - rule.minimum_edge);
      EXPECT_GE(extreme->thickness, required - 0.02) << "the outline's points are 1 mm apart";
      if (share == 1.0) {
        EXPECT_GE(extreme->thickness, rule.minimum_centre - 1e-8);
      }
      touch = std::min(touch, extreme->thickness - required);
    }
    EXPECT_LE(touch, 0.02) << "between the outline's points it may be a little thinner";
  }
  EXPECT_GT(made, 250);
}

TEST(LensForm, AFrontThatDoesNotReachTheEdgeIsRefusedWithItsRadius) {
  const auto form = ThinnestLensForm(Spec(15.0, 1.498), Sphere(9.0), Ellipse(68.0, 50.0), {1.5, 1.0, 25.0});
  ASSERT_FALSE(form);
  EXPECT_THAT(form.error().Text(), testing::HasSubstr("radius 33.2 mm"));
  EXPECT_THAT(form.error().Text(), testing::HasSubstr("34.0 mm from the box centre"));
}

TEST(LensForm, ATooThickLensIsRefusedWithItsThickness) {
  const auto form = ThinnestLensForm(Spec(1.0, 1.6), Sphere(-16.0), Ellipse(50.0, 40.0), {1.5, 1.0, 10.0});
  ASSERT_FALSE(form);
  EXPECT_THAT(form.error().Text(), testing::HasSubstr("mm thick, more than 10.0 mm"));
}

TEST(LensForm, CompensationGivesTheWantedPowerByAnIndependentBundle) {
  test::Dice dice(77);
  for (int i = 0; i < 100; ++i) {
    const LensFormSpec spec = Spec(dice.Between(2.0, 7.0), 1.6);
    const LensOrder wanted{MatrixFrom({dice.Between(-8, 6), -dice.Between(0, 3), dice.Between(0.01, kPi)}),
                           {dice.Between(-2, 2), dice.Between(-2, 2)}};
    const double pantoscopic = dice.Between(0, 0.3);
    const double face_form = dice.Between(0, 0.3);
    const LensPose pose = PoseOf(pantoscopic, face_form, 13.0, Eye::kRight);
    const auto made = CompensatedLensForm(spec, {wanted, pose}, Ellipse(48.0, 36.0, 120), {1.5, 1.0, 25.0});
    ASSERT_TRUE(made) << made.error().Text();
    const auto bundle = test::BundlePower(made->form, pose);
    ASSERT_TRUE(bundle);
    EXPECT_LE(WorstMeridian(*bundle - wanted.power), 1e-4);
    const auto focimeter = TraceFocimeter(made->form);
    ASSERT_TRUE(focimeter);
    EXPECT_LE(WorstMeridian(focimeter->power - made->order.power), 1e-6) << "what to surface is what a focimeter reads";
  }
}

}  // namespace
}  // namespace annulus
