#include "modeling/glasses/frame_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "base/units.h"
#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/mesh/mesh_io.h"

namespace annulus {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What version 1 of the program wrote.
const char* const kVersion1 = R"({
  "format": "annulus-frame",
  "version": 1,
  "style": "boston",
  "parameters": {
    "width_mm": 50.0,
    "upper_outer_mm": 8.8,
    "upper_inner_mm": 8.8,
    "upper_thickness_mm": 3.0,
    "lower_outer_mm": 11.0704,
    "lower_inner_mm": 11.0704,
    "lower_thickness_mm": 2.5,
    "height_mm": 44.0,
    "bridge_height_mm": 27.28
  }
}
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Complaint(const std::string& json) {
  const auto file = FrameFromJson(json, "F.json");
  return file ? "fine" : file.error().Text();
}

std::string Stl(const FrameFile& file) {
  const auto frame = BuildFrame(file.design, file.adjustment.value_or(StandardAdjustment(file.design)));
  EXPECT_TRUE(frame) << frame.error().Text();
  return frame ? WriteStl(TessellateFrame(*frame, {.along = 6, .around = 4}), "frame") : "";
}

/// A design with every detail away from the paper's, bent for a crooked head.
FrameFile Everything() {
  FrameFile file;
  file.design = BuiltInFrameLibrary().Find("wellington").value()->design;
  file.design.details.bridge_gap = 17.3;
  file.design.details.tip_drop = RadiansFromDegrees(37.0);
  file.material = DesignMaterial::kAcetate;
  FrameAdjustment adjustment = StandardAdjustment(file.design);
  adjustment.temple_left.ear += Eigen::Vector3d(2.1, -3.3, 4.7);
  adjustment.temple_left.bow = 0.031;
  adjustment.temple_right.tip_in = 0.1 / 3.0;
  adjustment.pad_left.centre = {-9.1, -3.2, 1.0 / 7.0};
  file.adjustment = adjustment;
  return file;
}

void ExpectSame(const FrameFile& a, const FrameFile& b) {
  EXPECT_EQ(a.design, b.design);
  EXPECT_EQ(a.material, b.material);
  ASSERT_EQ(a.adjustment.has_value(), b.adjustment.has_value());
  EXPECT_EQ(FrameToJson(a), FrameToJson(b));
  EXPECT_EQ(Stl(a), Stl(b));
}

TEST(FrameJson, ReproducesEveryStyleToTheByte) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    const FrameFile file{ScaledToWidth(style.design, 51.7 / 1.2), style.material, {}};
    const auto read = FrameFromJson(FrameToJson(file), "FRAME.json");
    ASSERT_TRUE(read) << style.name << read.error().Text();
    ExpectSame(*read, file);
  }
}

TEST(FrameJson, ReproducesAnAdjustedFrameToTheByte) {
  const FrameFile file = Everything();
  const auto read = FrameFromJson(FrameToJson(file), "FRAME.json");
  ASSERT_TRUE(read) << read.error().Text();
  ExpectSame(*read, file);
  EXPECT_EQ(read->adjustment->temple_left.ear, file.adjustment->temple_left.ear);
  EXPECT_EQ(read->adjustment->temple_left.bow, 0.031);
  EXPECT_EQ(read->adjustment->temple_right.tip_in, 0.1 / 3.0);
  EXPECT_EQ(read->adjustment->pad_left.centre, file.adjustment->pad_left.centre);
}

TEST(FrameJson, ReadsEveryAngleBackToTheSameBits) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(0.0, RadiansFromDegrees(20.0));
  std::size_t in_radians = 0;
  for (int k = 0; k < 500; ++k) {
    FrameFile file;
    file.design.details.face_form = angle(random);
    const std::string text = FrameToJson(file);
    in_radians += text.find("face_form_rad") != std::string::npos ? 1 : 0;
    const auto read = FrameFromJson(text, "FRAME.json");
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(read->design.details.face_form, file.design.details.face_form);
  }
  EXPECT_GT(in_radians, 0U);    // some have no degrees that read back exactly
  EXPECT_LT(in_radians, 100U);  // most do
}

TEST(FrameJson, WritesDegreesAsTheyWereTyped) {
  for (const char* text : {"0.1", "4.0", "5.0", "7.3", "12.25", "19.9"}) {
    const FrameFile file{WithField(FrameDesign(), "face-form", text).value(), {}, {}};
    EXPECT_THAT(FrameToJson(file), HasSubstr(std::string("\"face_form_deg\": ") + text + "\n"));
  }
}

TEST(FrameJson, WritesOnlyTheDetailsThatAreNotThePapers) {
  FrameFile file;
  EXPECT_THAT(FrameToJson(file), Not(HasSubstr("details")));
  file.design.details.bridge = BridgeForm::kSaddle;
  EXPECT_THAT(FrameToJson(file), HasSubstr("\"details\": {\n    \"bridge\": \"saddle\"\n  }"));
}

TEST(FrameJson, ReadsVersion1) {
  const auto read = FrameFromJson(kVersion1, "F.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(read->design.style, "boston");
  EXPECT_EQ(read->design.parameters.lower_inner, 11.0704);
  EXPECT_EQ(read->design.parameters.bridge_height, 27.28);
  EXPECT_EQ(read->design.details, FrameDetails());
  EXPECT_FALSE(read->material);
  EXPECT_FALSE(read->adjustment);
}

TEST(FrameJson, NamesTheFileAndTheKeyThatIsWrong) {
  const std::string good = FrameToJson(Everything());
  EXPECT_EQ(Complaint(good), "fine");
  const std::string tall = Complaint(Replaced(good, "\"height_mm\": ", "\"height_mm\": \"tall\", \"x\": "));
  EXPECT_THAT(tall, HasSubstr("F.json"));
  EXPECT_THAT(tall, HasSubstr("parameters.height_mm"));
  EXPECT_THAT(Complaint(Replaced(good, "\"height_mm\": ", "\"height_mm\": 1e400, \"x\": ")), Not("fine"));
  EXPECT_THAT(Complaint(Replaced(good, "\"height_mm\": ", "\"height_mm\": 4")), HasSubstr("height"));
  EXPECT_THAT(Complaint(Replaced(good, "annulus-frame", "annulus-worn")), HasSubstr("annulus-frame"));
  EXPECT_THAT(Complaint(Replaced(good, "\"version\": 2", "\"version\": 3")), HasSubstr("version"));
  EXPECT_THAT(Complaint(Replaced(good, "\"version\": 2", "\"version\": 2.0")), HasSubstr("version"));
  EXPECT_THAT(Complaint(Replaced(good, "\"version\": 2", "\"version\": 1")), HasSubstr("'material'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"acetate\"", "\"wood\"")), HasSubstr("'material' is 'wood'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"ear_mm\"", "\"ears\"")), HasSubstr("adjustment.temple_right.ear"));
  EXPECT_THAT(Complaint(Replaced(good, "\"pad_left\"", "\"pad\"")), HasSubstr("adjustment.pad"));
}

TEST(FrameJson, RefusesUnknownKeysByName) {
  const std::string good = FrameToJson(Everything());
  EXPECT_THAT(Complaint(Replaced(good, "\"style\"", "\"stile\"")), HasSubstr("there is no key 'stile'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"width_mm\"", "\"x\": 1, \"width_mm\"")),
              HasSubstr("there is no key 'parameters.x'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"groove_depth_mm\"", "\"groove_dept_mm\"")),
              HasSubstr("there is no key 'details.groove_dept_mm'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"bow_deg\"", "\"bow_grad\"")),
              HasSubstr("there is no key 'adjustment.temple_right.bow_grad'"));
}

TEST(FrameJson, RefusesAPadThatStandsNowhere) {
  FrameFile file = Everything();
  file.adjustment->pad_right.normal = {1.0, 0.0, 0.1};
  EXPECT_THAT(Complaint(FrameToJson(file)), HasSubstr("perpendicular unit vectors"));
}

TEST(FrameJson, RefusesAnEarThatTheTempleCannotReach) {
  FrameFile file = Everything();
  file.adjustment->temple_left.ear.y() = 10.0;
  EXPECT_THAT(Complaint(FrameToJson(file)), HasSubstr("ear point"));
}

TEST(FrameJson, RefusesEveryTruncation) {
  const std::string good = FrameToJson(Everything());
  // The last two characters are the closing brace and the line feed.
  for (std::size_t length = 0; length + 2 <= good.size(); ++length) {
    EXPECT_NE(Complaint(good.substr(0, length)), "fine") << length;
  }
}

TEST(FrameJson, RefusesForeignText) {
  for (const char* foreign : {"", "null", "[]", "{}", "level,z_mm", "\xff\xfe", "{\"format\": 3}", "[[[[[[[["}) {
    EXPECT_NE(Complaint(foreign), "fine") << foreign;
  }
  EXPECT_NE(Complaint(std::string(100000, '[')), "fine");
}

}  // namespace
}  // namespace annulus
