#include "modeling/glasses/frame_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <string>

#include "base/units.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using testing::HasSubstr;

FrameDesign With(const FrameDesign& design, const char* option, const char* text) {
  const Result<FrameDesign> changed = WithField(design, option, text);
  EXPECT_TRUE(changed) << option << " " << text;
  return changed.value_or(FrameDesign());
}

TEST(FrameFields, NameEveryFieldOnceWithItsUnit) {
  std::set<std::string_view> options;
  std::set<std::string_view> keys;
  for (const FrameField& field : FrameFields()) {
    EXPECT_TRUE(options.insert(field.option).second) << field.option;
    EXPECT_TRUE(keys.insert(field.key).second) << field.key;
    EXPECT_FALSE(field.description.empty()) << field.option;
    EXPECT_EQ(field.key.ends_with("_mm"), field.unit == FieldUnit::kMillimetres) << field.key;
    EXPECT_EQ(field.key.ends_with("_deg"), field.unit == FieldUnit::kDegrees) << field.key;
    EXPECT_EQ(field.key.ends_with("_dpt"), field.unit == FieldUnit::kDioptres) << field.key;
    EXPECT_EQ(field.low < field.high, field.unit != FieldUnit::kWord) << field.key;
  }
  // 9 lengths of the paper; 5 forms and 17 numbers of FrameDetails.
  EXPECT_EQ(options.size(), 31U);
}

TEST(FrameFields, AreAllInTheDescriptionOfTheFormat) {
  std::ifstream file(test::SourceFolder() + "/docs/formats.md");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (const FrameField& field : FrameFields()) {
    EXPECT_NE(text.find("`" + std::string(field.key) + "`"), std::string::npos) << field.key;
    for (const std::string_view word : FormWords(field)) EXPECT_NE(text.find(word), std::string::npos) << word;
  }
}

TEST(FrameFields, CoverEveryMemberOfTheDetails) {
  // Every field set away from the paper's value: two such designs are equal only if each member was reached.
  FrameDesign design;
  for (const FrameField& field : FrameFields()) {
    if (field.unit == FieldUnit::kWord) {
      design = WithFormWord(field, design, FormWords(field).back()).value();
    } else if (!IsParameter(field)) {
      design = WithStoredNumber(field, design, 1.25);
    }
  }
  FrameDetails expected;
  expected.rim = RimForm::kRimless;
  expected.bridge = BridgeForm::kKeyhole;
  expected.pads = PadForm::kAdjustable;
  expected.temple = TempleForm::kStraight;
  expected.hinge = HingeForm::kBarrel;
  for (auto member : {&FrameDetails::bridge_gap, &FrameDetails::depth, &FrameDetails::arm_height,
                      &FrameDetails::arm_width, &FrameDetails::bridge_forward, &FrameDetails::bridge_rise}) {
    expected.*member = 1.25;
  }
  for (auto member :
       {&FrameDetails::groove_depth, &FrameDetails::groove_width, &FrameDetails::lens_edge, &FrameDetails::frame_curve,
        &FrameDetails::face_form, &FrameDetails::end_piece, &FrameDetails::tip_length, &FrameDetails::tip_drop,
        &FrameDetails::pad_length, &FrameDetails::pad_width, &FrameDetails::temple_outset}) {
    expected.*member = 1.25;
  }
  // A member that is not listed here keeps the size of the struct from being what it is.
  static_assert(sizeof(FrameDetails) == 5 * 4 + 4 + 6 * sizeof(std::optional<double>) + 11 * sizeof(double));
  EXPECT_EQ(design.details, expected);
}

TEST(FrameFields, TakeMillimetresPercentagesAndWords) {
  const FrameDesign d;  // 50 × 40 mm
  EXPECT_DOUBLE_EQ(With(d, "upper-outer", "7.5").parameters.upper_outer, 7.5);
  EXPECT_DOUBLE_EQ(With(d, "height", "80%").parameters.height, 40.0);
  EXPECT_DOUBLE_EQ(With(d, "lower-inner", "quite round").parameters.lower_inner, 0.2516 * 40.0);
  EXPECT_DOUBLE_EQ(With(d, "lower-inner", "slightly-square").parameters.lower_inner, 0.12 * 40.0);
  EXPECT_DOUBLE_EQ(With(d, "upper-thickness", "slightly thick").parameters.upper_thickness, 0.075 * 50.0);
  EXPECT_DOUBLE_EQ(With(d, "height", "quite-large").parameters.height, 50.0);
  EXPECT_DOUBLE_EQ(With(d, "bridge-height", "middle").parameters.bridge_height, 0.6 * 40.0);
  EXPECT_DOUBLE_EQ(With(d, "width", "25").parameters.height, 20.0);
  EXPECT_DOUBLE_EQ(With(d, "groove-depth", "0.8").details.groove_depth, 0.8);
  EXPECT_DOUBLE_EQ(With(d, "bridge-gap", "36%").details.bridge_gap.value(), 18.0);
}

TEST(FrameFields, TakeDegreesAndForms) {
  const FrameDesign d;
  EXPECT_DOUBLE_EQ(With(d, "face-form", "5").details.face_form, kPi / 36.0);
  EXPECT_EQ(With(d, "frame-curve", "4").details.frame_curve, 4.0);
  EXPECT_EQ(With(d, "bridge", "keyhole").details.bridge, BridgeForm::kKeyhole);
  EXPECT_EQ(With(d, "rim", "half").details.rim, RimForm::kHalf);
  EXPECT_EQ(With(d, "hinge", "barrel").details.hinge, HingeForm::kBarrel);
  EXPECT_EQ(With(d, "temple", "skull").details.temple, TempleForm::kSkull);
  EXPECT_EQ(With(d, "pads", "adjustable").details.pads, PadForm::kAdjustable);
}

TEST(FrameFields, GoBackToThePaper) {
  FrameDesign d = With(FrameDesign(), "depth", "4");
  d = With(d, "pad-length", "9");
  EXPECT_FALSE(With(d, "depth", "paper").details.depth);
  EXPECT_EQ(With(d, "pad-length", "paper").details.pad_length, FrameDetails().pad_length);
  EXPECT_FALSE(WithField(d, "height", "paper"));
}

TEST(FrameFields, SayWhatIsWrongWithAValue) {
  for (const FrameField& field : FrameFields()) {
    for (const char* bad : {"", "abc", "7x", "nan", "inf", "-", "%", "1e999", "rounder"}) {
      const auto changed = WithField(FrameDesign(), field.option, bad);
      ASSERT_FALSE(changed) << field.option << " " << bad;
      EXPECT_THAT(changed.error().Text(), HasSubstr(std::string(field.option))) << bad;
    }
  }
  EXPECT_FALSE(WithField(FrameDesign(), "height", "0"));
  EXPECT_FALSE(WithField(FrameDesign(), "groove-depth", "-1"));
  EXPECT_TRUE(WithField(FrameDesign(), "bridge-rise", "-1"));
  EXPECT_FALSE(WithField(FrameDesign(), "height", "quite round"));
  EXPECT_FALSE(WithField(FrameDesign(), "face-form", "5%"));
  EXPECT_FALSE(WithField(FrameDesign(), "colour", "3"));
  EXPECT_THAT(WithField(FrameDesign(), "bridge", "arch").error().advice, HasSubstr("straight, saddle, keyhole"));
}

TEST(FrameFields, FindTheNearestWord) {
  const FrameDesign square = With(FrameDesign(), "upper-outer", "2.1");  // 0.0525 of 40 mm
  EXPECT_EQ(NearestWord(*FindFrameField("upper-outer"), square), "quite square");
  for (const FrameField& field : FrameFields()) {
    for (const NamedShare& named : field.words) {
      const auto changed = WithField(FrameDesign(), field.option, named.word);
      ASSERT_TRUE(changed);
      EXPECT_EQ(NearestWord(field, *changed), named.word) << field.option;
    }
  }
  EXPECT_EQ(NearestWord(*FindFrameField("groove-depth"), square), "");
}

TEST(FrameFields, KeepNoNegativeZero) {
  EXPECT_FALSE(std::signbit(With(FrameDesign(), "face-form", "-0").details.face_form));
}

}  // namespace
}  // namespace annulus
