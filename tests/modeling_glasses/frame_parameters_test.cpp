#include "modeling/glasses/frame_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using testing::HasSubstr;

FrameParameters Example(const char* name) { return test::PaperStyle(name); }

std::string Complaint(const FrameParameters& parameters) {
  const Status status = Validate(parameters);
  return status ? "valid" : status.error().Text();
}

TEST(FrameParameters, DeriveThePapersConstantsFromTheWidth) {
  FrameParameters p;
  p.width = 60.0;
  EXPECT_DOUBLE_EQ(p.bridge_gap(), 12.0);   // l0 = l1/5
  EXPECT_DOUBLE_EQ(p.depth(), 3.0);         // s = l1/20
  EXPECT_DOUBLE_EQ(p.arm_segment(), 6.0);   // l4 = l5 = l7 = l8 = l9 = l1/10
  EXPECT_DOUBLE_EQ(p.rim_spacing(), 72.0);  // l1 + l0
}

TEST(FrameParameters, DefaultsAndAllStylesAreValid) {
  EXPECT_EQ(Complaint(FrameParameters{}), "valid");
  for (const test::FrameStyle& style : test::FrameStyles())
    EXPECT_EQ(Complaint(style.parameters), "valid") << style.name;
}

TEST(FrameParameters, ExamplesHaveThePapersProportions) {
  EXPECT_DOUBLE_EQ(Example("example1").height, Example("example1").width);
  EXPECT_DOUBLE_EQ(Example("example2").height, Example("example2").width);
  EXPECT_DOUBLE_EQ(Example("example2").upper_outer, 0.2516 * 50.0);
  EXPECT_NEAR(Example("example3").height / Example("example3").width, 0.7, 1e-12);
  EXPECT_NEAR(Example("example4").height / Example("example4").width, 0.8, 1e-12);
  EXPECT_NEAR(Example("example4").upper_thickness / Example("example4").lower_thickness, 3.0, 1e-12);
  for (const char* name : {"example1", "example2", "example3"}) {
    EXPECT_NEAR(Example(name).upper_thickness, Example(name).depth(), 1e-12);  // d1 = d2 = s
    EXPECT_NEAR(Example(name).lower_thickness, Example(name).depth(), 1e-12);
  }
}

TEST(FrameParameters, RefusesCornersThatDoNotFitTheirSide) {
  // t_i + t_j <= side/√2: two cuts of 18 mm on a side of 50 mm are 36 > 35.36.
  FrameParameters p = Example("example2");
  p.upper_outer = 18.0;
  p.upper_inner = 18.0;
  EXPECT_THAT(Complaint(p), HasSubstr("upper-outer and upper-inner add up to 36.000 mm"));
  p = Example("example3");
  p.upper_outer = 17.0;
  p.lower_outer = 9.0;
  EXPECT_THAT(Complaint(p), HasSubstr("upper-outer and lower-outer"));
}

TEST(FrameParameters, RefusesACornerSharperThanTheRimAllows) {
  FrameParameters p = Example("example1");
  p.lower_inner = 0.2;  // d2·tan(22.5°)/2 = 0.518 mm
  EXPECT_THAT(Complaint(p), HasSubstr("lower-inner is 0.200 mm"));
  EXPECT_THAT(Complaint(p), HasSubstr("from 0.518"));
}

TEST(FrameParameters, RefusesABridgeBesideTheSides) {
  FrameParameters p = Example("example2");
  p.bridge_height = 49.0;
  EXPECT_THAT(Complaint(p), HasSubstr("bridge-height is 49.000 mm"));
  // M3 and M0 are 12.58/√2 = 8.895 mm below the upper side, half of d1 is 1.25 mm.
  EXPECT_THAT(Complaint(p), HasSubstr("to 39.855 mm"));
}

TEST(FrameParameters, RefusesWhatIsNotAPositiveLength) {
  for (const FrameParameterField& field : FrameParameterFields()) {
    for (const double bad :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      FrameParameters p;
      p.*field.member = bad;
      EXPECT_THAT(Complaint(p), HasSubstr(std::string(field.option))) << bad;
    }
  }
}

TEST(FrameParameters, RefusesSizesThatNoFaceNeeds) {
  EXPECT_THAT(Complaint(ScaledToWidth(FrameParameters{}, 500.0)), HasSubstr("width"));
  FrameParameters p;
  p.height = 100.0;
  EXPECT_THAT(Complaint(p), HasSubstr("height"));
  p = FrameParameters{};
  p.lower_thickness = 20.0;
  EXPECT_THAT(Complaint(p), HasSubstr("lower-thickness"));
}

TEST(FrameParameters, ScaleKeepsShape) {
  const FrameParameters scaled = ScaledToWidth(Example("example4"), 25.0);
  EXPECT_EQ(scaled.width, 25.0);
  EXPECT_NEAR(scaled.height, 0.8 * 25.0, 1e-12);
  EXPECT_NEAR(scaled.lower_outer, 0.5 * Example("example4").lower_outer, 1e-12);
}

TEST(FrameParameters, UnknownStyleListsTheKnownOnes) {
  const auto style = BuiltInFrameLibrary().Find("baroque");
  ASSERT_FALSE(style);
  EXPECT_THAT(style.error().advice, HasSubstr("example1"));
  EXPECT_THAT(style.error().advice, HasSubstr("boston"));
}

TEST(FrameParameters, WordsGrowRounder) {
  double previous = 0.0;
  for (const Roundness word : {Roundness::kQuiteSquare, Roundness::kSlightlySquare, Roundness::kMiddle,
                               Roundness::kSlightlyRound, Roundness::kQuiteRound, Roundness::kExtremelyRound}) {
    EXPECT_GT(RoundnessShare(word), previous) << RoundnessWord(word);
    previous = RoundnessShare(word);
  }
}

}  // namespace
}  // namespace annulus
