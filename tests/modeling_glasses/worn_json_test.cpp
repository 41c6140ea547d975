#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "base/units.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/placement.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using testing::HasSubstr;

WornFrame Worn(const char* style) {
  FacePoints face;
  face.eye_right = {{31.25, 80, 1580.1}, LandmarkSource::kDetected};
  face.eye_left = {{-30.5, 80, 1581.7}, LandmarkSource::kGiven};
  face.ear_right = {{76, 4, 1584}, LandmarkSource::kProportion};
  face.ear_left = {{-76, 4, 1584}, LandmarkSource::kDetected};
  face.forehead = {{0.1, 99, 1620}, LandmarkSource::kDetected};
  face.sellion = {{0, 94, 1588}, LandmarkSource::kDetected};
  face.pronasale = {{0, 113, 1550}, LandmarkSource::kDetected};
  return PlaceFrame(BuiltInFrameLibrary().Find(style).value()->design, face).value();
}

WornFile Full() {
  WornFile file{Worn("wellington"), DesignMaterial::kAcetate, {}};
  file.SetSection("fit", R"({"goals": [{"id": "pd", "value": 62.5}], "wearable": true})");
  file.SetSection("order", R"({"z": 1, "a": 0.1})");
  return file;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Complaint(const std::string& json) {
  const auto file = WornFileFromJson(json, "W.json");
  return file ? "fine" : file.error().Text();
}

/// A file that version 1 of the program wrote.
std::string Version1() {
  std::ifstream file(test::SourceFolder() + "/tests/fuzz/corpus/worn_json/version1");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(WornJson, ReadsBackTheSameBits) {
  for (const char* style : {"example4", "boston", "aviator", "rimless-oval"}) {
    const WornFrame worn = Worn(style);
    const std::string text = WornFrameToJson(worn);
    const auto read = WornFrameFromJson(text, "WORN.json");
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(WornFrameToJson(*read), text);
    EXPECT_EQ(read->design, worn.design);
    EXPECT_EQ(read->station_from_frame.matrix(), worn.station_from_frame.matrix());
    EXPECT_EQ(read->face.eye_left.source, LandmarkSource::kGiven);
    EXPECT_EQ(read->face.ear_right.source, LandmarkSource::kProportion);
    EXPECT_EQ(read->tilt, worn.tilt);
    EXPECT_EQ(read->adjustment.temple_left.ear, worn.adjustment.temple_left.ear);
    EXPECT_EQ(read->l6_left, worn.l6_left);
    EXPECT_EQ(read->residuals.ear_left, worn.residuals.ear_left);
  }
}

TEST(WornJson, KeepsSectionsOfOthersAsTheyAre) {
  const WornFile file = Full();
  const auto read = WornFileFromJson(WornFileToJson(file), "W.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(WornFileToJson(*read), WornFileToJson(file));
  EXPECT_EQ(read->material, DesignMaterial::kAcetate);
  EXPECT_EQ(read->Section("order"), R"({"z":1,"a":0.1})");  // order of keys and values
  EXPECT_THAT(std::string(read->Section("fit")), HasSubstr("62.5"));
  EXPECT_EQ(read->Section("lens"), "");
}

TEST(WornJson, ReplacesASection) {
  WornFile file = Full();
  file.SetSection("order", "{}");
  EXPECT_EQ(file.Section("order"), "{}");
  EXPECT_EQ(file.sections.size(), 2U);
  EXPECT_ANY_THROW(file.SetSection("order", "3"));
}

TEST(WornJson, ReadsVersion1) {
  const auto read = WornFileFromJson(Version1(), "W.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(read->worn.design.details, FrameDetails());
  EXPECT_NEAR(read->worn.tilt, RadiansFromDegrees(15.0), 1e-12);
  EXPECT_EQ(read->worn.l6_right, 118.30394052272106);  // as the file itself says
  EXPECT_TRUE(read->sections.empty());
}

TEST(WornJson, RefusesEveryTruncation) {
  const std::string good = WornFileToJson(Full());
  for (std::size_t length = 0; length + 2 <= good.size(); length += 3) {
    EXPECT_NE(Complaint(good.substr(0, length)), "fine") << length;
  }
}

TEST(WornJson, RefusesWhatIsNoPlacement) {
  const std::string good = WornFileToJson(Full());
  EXPECT_THAT(Complaint(Replaced(good, "\"detected\"", "\"guessed\"")), HasSubstr("face_points"));
  EXPECT_THAT(Complaint(Replaced(good, "\"rotation\"", "\"rotations\"")), HasSubstr("station_from_frame.rotation"));
  EXPECT_THAT(Complaint(Replaced(good, "\"tilt_", "\"tilts_")), HasSubstr("tilts_"));
  EXPECT_THAT(Complaint(Replaced(good, "\"l6_left_mm\"", "\"l6\"")), HasSubstr("'l6'"));
  EXPECT_THAT(Complaint(Replaced(good, "\"bridge_mm\"", "\"bridge\"")), HasSubstr("residuals.bridge_mm"));
  EXPECT_THAT(Complaint(Replaced(good, "0.965", "0.865")), HasSubstr("no rotation"));
  EXPECT_THAT(Complaint(Replaced(good, "\"fit\": {", "\"fit\": 3, \"other\": {")), HasSubstr("sections.fit"));
  EXPECT_THAT(Complaint(Replaced(good, "\"version\": 2", "\"version\": 1")), HasSubstr("'design'"));
}

TEST(WornJson, RefusesForeignText) {
  for (const char* foreign : {"", "null", "[]", "{}", "level,z_mm", "\xff\xfe", "{\"format\": 3}", "[[[[[[[["}) {
    EXPECT_NE(Complaint(foreign), "fine") << foreign;
  }
  std::string deep = WornFileToJson(Full());
  deep = Replaced(deep, "\"z\": 1", "\"z\": " + std::string(1000, '[') + std::string(1000, ']'));
  EXPECT_THAT(Complaint(deep), HasSubstr("levels deep"));
}

}  // namespace
}  // namespace annulus
