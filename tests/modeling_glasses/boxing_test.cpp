#include "modeling/glasses/boxing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/units.h"
#include "modeling/glasses/frame_adjust.h"
#include "modeling/glasses/frame_library.h"

namespace annulus {
namespace {

using testing::HasSubstr;

FrameDesign Style(const char* name) { return BuiltInFrameLibrary().Find(name).value()->design; }

TEST(Boxing, OfARectangularRimIsTheRectangleLessTheRim) {
  // With cuts as sharp as the rim allows, the sides of the inner outline are straight lines but for the corners: its
  // extent is that of the side tubes' middles, the control polygon's straight part: l - d less the Bezier's own sag.
  // At u = 1/2 a cubic has 3/4 of its middle control points and 1/4 of its ends.
  FrameDesign design = Style("example1");
  const FrameParameters& p = design.parameters;
  const double cut = p.upper_outer;
  const double side = 0.5 * (p.width - p.upper_thickness);  // inner side of the rectangle, from O0
  const double corner = 0.5 * p.width - (cut + 0.5 * p.upper_thickness) / std::sqrt(2.0);  // inner M0's x
  const FrameBoxing boxing = BoxingOf(design).value();
  EXPECT_NEAR(boxing.a, 2.0 * (0.75 * side + 0.25 * corner), 1e-9);
  EXPECT_NEAR(boxing.b, boxing.a, 1e-9);  // l1 = l2
  EXPECT_NEAR(boxing.dbl, design.rim_spacing() - boxing.a, 1e-9);
  EXPECT_NEAR(boxing.box_distance, design.rim_spacing(), 1e-9);
  EXPECT_NEAR(boxing.box_height, 0.0, 1e-9);
}

TEST(Boxing, OfTheRoundestRimIsACircle) {
  // The paper's roundest rim: its centre line is a circle of radius 0.911 · l1/2 within 0.5 %; the lens' is d1/2 less.
  const FrameBoxing boxing = BoxingOf(Style("example2")).value();
  const double radius = 0.911 * 25.0 - 0.5 * 2.5;
  EXPECT_NEAR(boxing.a, 2.0 * radius, 0.005 * 2.0 * radius);
  EXPECT_NEAR(boxing.ed, boxing.a, 0.01 * boxing.a);
  EXPECT_NEAR(boxing.circumference, kTwoPi * radius, 0.005 * kTwoPi * radius);
}

TEST(Boxing, OfAGroovedRimReachesTheGroovesBottom) {
  FrameDesign design = Style("example1");
  design.details.depth = 4.0;
  const FrameBoxing plain = BoxingOf(design).value();
  design.details.groove_width = 1.0;
  design.details.groove_depth = 0.5;
  const FrameBoxing grooved = BoxingOf(design).value();
  // The opening lies a little behind the inner seam, the bottom 0.5 mm behind the opening.
  EXPECT_GT(grooved.a - plain.a, 2.0 * 0.5);
  EXPECT_LT(grooved.a - plain.a, 2.0 * 0.9);
  EXPECT_NEAR(grooved.a + grooved.dbl, plain.a + plain.dbl, 1e-9);
}

TEST(Boxing, MeasuresTheLensInItsOwnPlaneAndDblInTheFront) {
  FrameDesign design = Style("example1");
  const FrameBoxing flat = BoxingOf(design).value();
  design.details.face_form = RadiansFromDegrees(20.0);
  const FrameBoxing wrapped = BoxingOf(design).value();
  EXPECT_NEAR(wrapped.a, flat.a, 1e-9);
  EXPECT_NEAR(wrapped.b, flat.b, 1e-9);
  // Turned about the vertical through O0, the nasal edge comes nearer to O0 by its cosine.
  EXPECT_NEAR(wrapped.dbl, design.rim_spacing() - flat.a * std::cos(RadiansFromDegrees(20.0)), 1e-9);
}

TEST(Boxing, SolvesABoxExactly) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> a(40.0, 62.0);
  std::uniform_real_distribution<double> b(30.0, 50.0);
  std::uniform_real_distribution<double> dbl(12.0, 26.0);
  std::size_t solved = 0;
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    for (int k = 0; k < 20; ++k) {
      const WantedBox wanted{a(random), b(random), dbl(random)};
      const auto design = DesignForBox(style.design, wanted);
      if (!design) continue;  // such a shape may be impossible
      ++solved;
      const FrameBoxing boxing = BoxingOf(*design).value();
      EXPECT_NEAR(boxing.a, wanted.a, 1e-6) << style.name;
      EXPECT_NEAR(boxing.b, *wanted.b, 1e-6) << style.name;
      EXPECT_NEAR(boxing.dbl, *wanted.dbl, 1e-6) << style.name;
    }
  }
  EXPECT_GE(solved, 20 * BuiltInFrameLibrary().styles.size() * 9 / 10);
}

TEST(Boxing, KeepsProportionsAndSectionsWhenOnlyTheWidthIsWanted) {
  const FrameDesign start = Style("wellington");
  const FrameBoxing before = BoxingOf(start).value();
  const FrameDesign scaled = ScaledToBox(start, 44.0).value();
  const FrameBoxing after = BoxingOf(scaled).value();
  EXPECT_NEAR(after.a, 44.0, 1e-6);
  EXPECT_NEAR(after.b / after.a, before.b / before.a, 1e-7);
  EXPECT_EQ(scaled.parameters.upper_thickness, start.parameters.upper_thickness);
  EXPECT_EQ(scaled.details.depth, start.details.depth);
  EXPECT_FALSE(scaled.details.bridge_gap);  // still the paper's l1/5
}

TEST(Boxing, KeepsTheRoundnessOfCorners) {
  const FrameDesign start = Style("example3");
  const FrameParameters p = DesignForBox(start, {60.0, 50.0, 18.0})->parameters;
  const double shorter = std::min(p.width, p.height);
  EXPECT_NEAR(p.upper_outer / shorter, 0.12, 1e-12);
  EXPECT_NEAR(p.lower_inner / shorter, 0.20, 1e-12);
  EXPECT_NEAR(p.bridge_height / p.height, 0.6, 1e-12);
}

TEST(Boxing, RefusesBoxesThatAreNone) {
  EXPECT_FALSE(DesignForBox(Style("example1"), {-3.0, {}, {}}));
  EXPECT_FALSE(DesignForBox(Style("example1"), {std::nan(""), {}, {}}));
  EXPECT_FALSE(DesignForBox(Style("example1"), {50.0, 0.0, {}}));
  EXPECT_FALSE(DesignForBox(Style("example1"), {50.0, 1.0, {}}));
  EXPECT_FALSE(DesignForBox(Style("example1"), {5000.0, {}, {}}));
  EXPECT_FALSE(DesignForBox(Style("example1"), {50.0, 40.0, 0.5}));
}

TEST(Boxing, WritesSizesAsFramesAreMarked) {
  FrameBoxing boxing;
  boxing.a = 51.6;
  boxing.dbl = 17.5;
  EXPECT_EQ(SizeText(boxing, 140.4), "52□18-140");
  EXPECT_EQ(SizeText(boxing, {}), "52□18");
}

TEST(Boxing, ReadsSizesAsPeopleTypeThem) {
  for (const char* text : {"52□18-140", "52-18-140", "52x18-140", "52/18/140", " 52 □ 18 - 140 ", "52.0-18.0-140.0"}) {
    const auto size = ParseSize(text);
    ASSERT_TRUE(size) << text;
    EXPECT_EQ(size->a, 52.0);
    EXPECT_EQ(size->dbl, 18.0);
    EXPECT_EQ(size->temple, 140.0);
    EXPECT_FALSE(size->b);
  }
  for (const char* text : {"", "52", "52-18", "52-18-", "52-18-140-3", "a-b-c", "52,18,140", "52--18-140", "nan-18-140",
                           "1e9-18-140", "52-18-inf", "52-18-1400", "-52-18-140"}) {
    EXPECT_FALSE(ParseSize(text)) << text;
  }
  EXPECT_THAT(ParseSize("wide").error().advice, HasSubstr("50-18-145"));
}

TEST(Temples, AreAsLongAsTheyAreSold) {
  for (const char* name : {"example1", "boston", "half-eye", "rimless-oval"}) {
    for (const double length : {125.0, 140.0, 150.0}) {
      const FrameDesign design = Style(name);
      const auto adjustment = AdjustmentForTemple(design, length);
      ASSERT_TRUE(adjustment) << name << adjustment.error().Text();
      const Frame frame = BuildFrame(design, *adjustment).value();
      EXPECT_NEAR(frame.arm_right.overall_length, length, 1e-6) << name;
      EXPECT_NEAR(frame.arm_left.overall_length, length, 1e-6) << name;
    }
  }
  EXPECT_FALSE(AdjustmentForTemple(Style("boston"), 30.0));
}

}  // namespace
}  // namespace annulus
