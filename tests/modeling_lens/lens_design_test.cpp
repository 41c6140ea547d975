#include "modeling/glasses/lens_design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/modeling_lens/lens_orders.h"

namespace annulus {
namespace {

using test::Ellipse;
using test::Material;
using test::Order;
using test::UsualFrame;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

/// The same, seen straight through.
FrameForLenses FlatFrame() {
  FrameForLenses frame = UsualFrame();
  frame.right.position = frame.left.position = {12.0, 0.0, 0.0};
  return frame;
}

LensPair MustDesign(const Prescription& rx, const FrameForLenses& frame, const LensOptions& options = {}) {
  const auto pair = DesignLensPair(rx, Material("1.60"), frame, options);
  EXPECT_TRUE(pair) << (pair ? "" : pair.error().Text());
  return pair.value_or(LensPair{});
}

std::string Complaint(const Prescription& rx, const FrameForLenses& frame, const LensOptions& options = {}) {
  const auto pair = DesignLensPair(rx, Material("1.60"), frame, options);
  return pair ? "designed" : pair.error().Text();
}

auto Says(const std::string& text) { return Contains(Field(&LensMessage::text, HasSubstr(text))); }

TEST(LensDesign, BaseCurveIsVogelsStockedOrGiven) {
  LensOptions options;
  EXPECT_EQ(BaseCurve(-4.0, options), 4.0);
  EXPECT_EQ(BaseCurve(3.0, options), 9.0);
  EXPECT_EQ(BaseCurve(0.0, options), 6.0);
  EXPECT_EQ(BaseCurve(-20.0, options), 0.0);
  EXPECT_EQ(BaseCurve(18.0, options), 16.0);
  options.base_rule = BaseCurveRule::kVogelStocked;
  EXPECT_EQ(BaseCurve(-3.5, options), 4.0);
  EXPECT_EQ(BaseCurve(-8.6, options), 2.0);
  options.base_rule = BaseCurveRule::kGiven;
  options.given_base = 7.25;
  EXPECT_EQ(BaseCurve(-4.0, options), 7.25);
}

TEST(LensDesign, MinusFourOnAFlatFrameIsTheTextbookLens) {
  Prescription rx = Order(-4.0, -4.0);
  for (EyePrescription* eye : {&rx.right, &rx.left}) {
    eye->pd = 38.0;  // (58 + 18) / 2: no decentration
    eye->height = 29.0;
  }
  FrameForLenses frame = FlatFrame();
  frame.right.outline = frame.left.outline = Ellipse(58.0, 58.0);
  LensOptions options;
  options.minimum_centre = 2.0;
  const auto pair = DesignLensPair(rx, Material("cr39"), frame, options);
  ASSERT_TRUE(pair) << pair.error().Text();
  for (const LensDesign* lens : {&pair->right, &pair->left}) {
    EXPECT_EQ(lens->base, 4.0);
    EXPECT_NEAR(lens->front_radius, 124.5, 1e-9);
    EXPECT_NEAR((*lens->front_centre - Eigen::Vector3d(0.0, 0.0, -124.5)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(lens->form.centre_thickness, 2.0, 1e-9);
    EXPECT_NEAR(lens->edge.thickest, 5.77, 0.01);
    EXPECT_NEAR(lens->edge.thinnest, 5.77, 0.01);
    EXPECT_NEAR(lens->thinnest, 2.0, 1e-9);
    EXPECT_NEAR(lens->decentration.norm(), 0.0, 1e-12);
    // 58 mm + 2 mm: the smallest stocked blank is 60.
    EXPECT_NEAR(lens->blank.minimum, 60.0, 1e-9);
    EXPECT_NEAR(lens->blank.exact, 60.0, 1e-9);
    EXPECT_EQ(lens->blank.stocked, 60.0);
    EXPECT_NEAR(lens->power.as_worn_error, 0.0, 1e-6);
    EXPECT_NEAR(lens->power.at_cornea.power.sphere, -4.0 / 1.048, 1e-9);
  }
}

TEST(LensDesign, DecentrationFollowsPdAndHeightForBothEyes) {
  const LensPair pair = MustDesign(Order(-2.0, -2.0), FlatFrame());
  // Box centres are (50 + 18)/2 = 34 mm from the middle, pupils 32: 2 mm in; 20 mm above a lower side 18 mm down.
  for (const LensDesign* lens : {&pair.right, &pair.left}) {
    EXPECT_NEAR(lens->decentration_in, 2.0, 1e-12);
    EXPECT_NEAR(lens->decentration.y(), 2.0, 1e-12);
    EXPECT_NEAR(lens->blank.minimum, 50.0 + 2.0 * std::hypot(2.0, 2.0) + 2.0, 1e-9);
    EXPECT_LE(lens->blank.exact, lens->blank.minimum);
  }
  EXPECT_NEAR(pair.right.decentration.x(), 2.0, 1e-12);  // the viewer's right is nasal
  EXPECT_NEAR(pair.left.decentration.x(), -2.0, 1e-12);
  // The temporal edge, farther from the optical centre, is the thick one.
  EXPECT_GT(std::cos(pair.left.edge.thickest_angle), 0.0);
  EXPECT_LT(std::cos(pair.right.edge.thickest_angle), 0.0);
}

TEST(LensDesign, FaceFormShortensTheBoxInFront) {
  FrameForLenses frame = FlatFrame();
  frame.right.position.face_form_angle = RadiansFromDegrees(20.0);
  const LensPair pair = MustDesign(Order(-2.0, -2.0), frame);
  EXPECT_NEAR(pair.right.decentration_in, 25.0 - 23.0 / std::cos(RadiansFromDegrees(20.0)), 1e-12);
}

TEST(LensDesign, AnOutlineAwayFromItsOriginGivesTheSameLens) {
  const LensPair here = MustDesign(Order(-5.0, 3.0), UsualFrame());
  FrameForLenses moved = UsualFrame();
  for (RimForLens* rim : {&moved.right, &moved.left}) {
    for (Eigen::Vector2d& point : rim->outline.points) point += Eigen::Vector2d(34.0, -7.0);
  }
  const LensPair there = MustDesign(Order(-5.0, 3.0), moved);
  EXPECT_NEAR(here.right.body.weight, there.right.body.weight, 1e-9);
  EXPECT_NEAR(here.right.edge.thickest, there.right.edge.thickest, 1e-9);
  EXPECT_NEAR(here.left.power.to_surface.power.cylinder, there.left.power.to_surface.power.cylinder, 1e-7);
}

TEST(LensDesign, TheEyesOfASymmetricOrderAreMirrorImages) {
  Prescription rx = Order(-3.0, -3.0);
  rx.right.cylinder = rx.left.cylinder = -1.5;
  rx.right.axis_deg = 20.0;
  rx.left.axis_deg = 160.0;
  rx.right.prism = rx.left.prism = {2.0, 0.5};
  const LensPair pair = MustDesign(rx, UsualFrame());
  EXPECT_NEAR(pair.right.body.weight, pair.left.body.weight, 1e-9);
  EXPECT_NEAR(pair.right.form.centre_thickness, pair.left.form.centre_thickness, 1e-9);
  EXPECT_NEAR(pair.right.power.to_surface.prism.x(), -pair.left.power.to_surface.prism.x(), 1e-6);
  EXPECT_NEAR(pair.right.power.to_surface.power.axis + pair.left.power.to_surface.power.axis, kPi, 1e-6);
  for (std::size_t i = 0; i < 360; ++i) {
    const std::size_t mirrored = (360 + 180 - i) % 360;
    EXPECT_NEAR(pair.right.edge.points[i].thickness(), pair.left.edge.points[mirrored].thickness(), 1e-7);
  }
}

TEST(LensDesign, TheTransposedOrderIsTheSameLens) {
  Prescription rx = Order(-3.0, 2.0);
  rx.right.cylinder = -1.5;
  rx.right.axis_deg = 20.0;
  Prescription other = rx;
  other.right = Transposed(rx.right);
  const LensPair a = MustDesign(rx, UsualFrame());
  const LensPair b = MustDesign(other, UsualFrame());
  EXPECT_NEAR(a.right.body.weight, b.right.body.weight, 1e-9);
  EXPECT_NEAR(a.right.power.to_surface.power.axis, b.right.power.to_surface.power.axis, 1e-9);
}

TEST(LensDesign, FifteenDegreesOnMinusFourLeaveTheToleranceUnlessCompensated) {
  FrameForLenses frame = FlatFrame();
  frame.right.position.pantoscopic_tilt = frame.left.position.pantoscopic_tilt = RadiansFromDegrees(15.0);
  Prescription rx = Order(-4.0, -4.0);
  rx.right.pd = 34.0;  // no decentration
  rx.right.height = 18.0;
  LensOptions options;
  options.power_order = PowerOrder::kAsPrescribed;
  const LensPair plain = MustDesign(rx, frame, options);
  // Martin: −4·sin²15°/3.2 = −0.084 DS and −0.29 DC (n 1.6), so −0.38 D in the worst meridian.
  EXPECT_NEAR(plain.right.power.martin.power.sphere, -4.084, 0.001);
  EXPECT_NEAR(plain.right.power.martin.power.cylinder, -0.29, 0.005);
  EXPECT_NEAR(plain.right.power.as_worn_error, 0.38, 0.02);
  EXPECT_FALSE(plain.right.power.within_tolerance);
  EXPECT_THAT(plain.right.messages, Says("as worn the power is off by"));
  const LensPair made = MustDesign(rx, frame);
  EXPECT_LE(made.right.power.as_worn_error, 1e-5);
  EXPECT_TRUE(made.right.power.within_tolerance);
  EXPECT_NEAR(made.right.power.uncompensated_error, plain.right.power.as_worn_error, 1e-9);
  EXPECT_FALSE(made.right.power.uncompensated_within_tolerance);
  // What is surfaced is weaker by what the tilt adds: −4·cos²15° / (1 + sin²15°/3.2) upright.
  EXPECT_NEAR(made.right.power.to_surface.power.sphere, -3.656, 0.02);
}

TEST(LensDesign, ThePrismOfTheTiltIsTakenOutOnlyIfAsked) {
  LensOptions options;
  const LensPair both = MustDesign(Order(4.0, 4.0), UsualFrame(), options);
  EXPECT_NEAR(both.right.power.as_worn.prism.norm(), 0.0, 1e-5);
  options.power_order = PowerOrder::kCompensatedPower;
  const LensPair power = MustDesign(Order(4.0, 4.0), UsualFrame(), options);
  EXPECT_EQ(power.right.power.to_surface.prism, Eigen::Vector2d::Zero());
  EXPECT_LE(power.right.power.as_worn_error, 1e-5);
  // A thick front of 10 D tilted by θ makes about F1·t/n·θ; base down, because the line of sight crosses it above the
  // optical centre.
  EXPECT_LT(power.right.power.as_worn.prism.y(), 0.0);
  const double thickness = power.right.form.centre_thickness / 1000.0;
  const double expected = 100.0 * 10.0 * thickness / 1.6 * std::sin(power.right.power.tilt.angle);
  EXPECT_NEAR(power.right.power.as_worn_prism_error, expected, 0.1 * expected);
}

TEST(LensDesign, TheWornVertexDistanceIsCompensatedFor) {
  FrameForLenses frame = FlatFrame();
  frame.right.position.vertex_distance = 16.0;
  const LensPair pair = MustDesign(Order(-10.0, -10.0), frame);
  EXPECT_NEAR(pair.right.power.at_cornea.power.sphere, -8.93, 0.005);
  // −10 D at 12 mm is −10 / (1 + 0.004·(−10)) = −10.417 D at 16 mm.
  EXPECT_NEAR(pair.right.power.wanted.power.sphere, -10.0 / 0.96, 1e-9);
  EXPECT_NEAR(pair.right.power.as_worn.power.sphere, -10.0 / 0.96, 1e-5);
  EXPECT_NEAR(pair.left.power.wanted.power.sphere, -10.0, 1e-9);
}

TEST(LensDesign, ImpossibleOrdersAreRefusedWithTheReason) {
  const FrameForLenses frame = UsualFrame();
  Prescription rx = Order(-4.0, -4.0);
  rx.right.sphere = -45.0;
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("right SPH is -45 D"));
  rx = Order(-4.0, -4.0);
  rx.left.pd.reset();
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("the left eye has no PD"));
  rx = Order(-4.0, -4.0);
  rx.left.height = 40.0;
  EXPECT_THAT(Complaint(rx, FlatFrame()), HasSubstr("the left pupil is 2.0 mm inwards and 22.0 mm above"));
  LensOptions options;
  options.base_rule = BaseCurveRule::kGiven;
  options.given_base = 16.0;
  FrameForLenses wide = UsualFrame();
  wide.right.outline = Ellipse(80.0, 50.0);
  rx = Order(9.0, 1.0);
  rx.right.pd = 45.0;
  EXPECT_THAT(Complaint(rx, wide, options), HasSubstr("the right lens: the front (radius 37.5 mm)"));
  options = {};
  options.largest_thickness = 4.0;
  EXPECT_THAT(Complaint(Order(-1.0, -12.0), frame, options), HasSubstr("the left lens: it would be"));
}

TEST(LensDesign, ImpossibleFramesPositionsAndOptionsAreRefusedByName) {
  const Prescription rx = Order(-1.0, -1.0);
  FrameForLenses frame = UsualFrame();
  frame.dbl = 2.0;
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("DBL in mm is 2, outside 5 to 40"));
  frame = UsualFrame();
  frame.left.position.vertex_distance = 45.0;
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("the left vertex distance in mm is 45"));
  frame = UsualFrame();
  frame.right.position.pantoscopic_tilt = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("the right pantoscopic tilt in degrees is nan"));
  frame = UsualFrame();
  frame.right.outline.points.resize(5);
  EXPECT_THAT(Complaint(rx, frame), HasSubstr("it has 5 points"));
  LensOptions options;
  options.minimum_edge = 0.0;
  EXPECT_THAT(Complaint(rx, UsualFrame(), options), HasSubstr("the minimum edge thickness in mm is 0"));
  options = {};
  options.stocked_bases.clear();
  EXPECT_THAT(Complaint(rx, UsualFrame(), options), HasSubstr("there are no stocked base curves"));
  const auto pair = DesignLensPair(rx, {"own", 3.0, SpectralLine::kD, 30.0, 1.2}, UsualFrame(), {});
  EXPECT_THAT(pair.error().Text(), HasSubstr("the index is 3"));
}

TEST(LensDesign, AnUnconfirmedCentrationIsMarked) {
  Prescription rx = Order(-1.0, -1.0);
  EXPECT_EQ(MustDesign(rx, UsualFrame()).centration, "confirmed by A. Optician");
  rx.centration_confirmed_by.clear();
  const LensPair pair = MustDesign(rx, UsualFrame());
  EXPECT_FALSE(pair.centration_confirmed);
  EXPECT_EQ(pair.centration, "estimate, confirm by optician");
  EXPECT_THAT(pair.messages, Says("confirm by optician"));
}

TEST(LensDesign, WhatIsDoubtfulIsSaid) {
  Prescription rx = Order(-5.03, 1.25);
  rx.refracted_vertex.reset();
  rx.right.add = 2.0;
  rx.right.height = 14.0;
  rx.left.height.reset();
  LensOptions options;
  options.stocked_blanks = {40.0};
  options.minimum_edge = 1.0;
  const LensPair pair = MustDesign(rx, UsualFrame(), options);
  EXPECT_THAT(pair.messages, Says("does not say at which vertex distance"));
  EXPECT_THAT(pair.right.messages, Says("no multiple of 1/8 D"));
  EXPECT_THAT(pair.right.messages, Says("ADD +2.00 D is carried"));
  EXPECT_THAT(pair.right.messages, Says("the fitting height of 14.0 mm is below the 18.0 mm"));
  EXPECT_THAT(pair.right.messages, Says("none is stocked"));
  EXPECT_THAT(pair.left.messages, Says("no fitting height is given"));
  EXPECT_THAT(pair.left.messages, Says("the bevel comes within"));
  EXPECT_EQ(pair.right.add, 2.0);
  const LensPair usual = MustDesign(Order(-3.12, -2.37), UsualFrame());
  EXPECT_TRUE(usual.messages.empty());
  for (const LensMessage& message : usual.right.messages) ADD_FAILURE() << message.text;
}

TEST(LensDesign, TheReportIsJsonWithUnits) {
  Prescription rx = Order(-4.0, 2.0);
  rx.right.prism = rx.left.prism = {1.0, 0.0};
  const LensPair pair = MustDesign(rx, UsualFrame());
  const std::string text = LensPairToJson(pair);
  EXPECT_EQ(LensPairToJson(MustDesign(rx, UsualFrame())), text) << "same input, same bytes";
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["format"], "annulus-lenses");
  EXPECT_EQ(json["material"]["line"], "e");
  EXPECT_EQ(json["centration"]["confirmed"], true);
  EXPECT_EQ(json["right"]["edge"]["points"].size(), 360U);
  EXPECT_EQ(json["right"]["weight_g"], pair.right.body.weight);
  EXPECT_NEAR(json["right"]["power"]["as_worn"]["sph_d"].get<double>(), -4.0, 1e-5);
  for (const char* eye : {"right", "left"}) {
    EXPECT_NEAR(json[eye]["power"]["as_worn"]["prism_in_cm_m"].get<double>(), 1.0, 1e-5);
  }
  // A flat surface has no radius.
  LensOptions flat;
  flat.base_rule = BaseCurveRule::kGiven;
  flat.given_base = 0.0;
  EXPECT_TRUE(nlohmann::json::parse(
                  LensPairToJson(MustDesign(Order(-4.0, -4.0), UsualFrame(), flat)))["right"]["front_radius_mm"]
                  .is_null());
}

}  // namespace
}  // namespace annulus
