#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "modeling/glasses/frame_parameters.h"
#include "modeling/glasses/placement.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

WornFrame Worn() {
  FacePoints face;
  face.eye_right = {{31.25, 80, 1580.1}, LandmarkSource::kDetected};
  face.eye_left = {{-30.5, 80, 1581.7}, LandmarkSource::kGiven};
  face.ear_right = {{76, 4, 1584}, LandmarkSource::kProportion};
  face.ear_left = {{-76, 4, 1584}, LandmarkSource::kDetected};
  face.forehead = {{0.1, 99, 1620}, LandmarkSource::kDetected};
  face.sellion = {{0, 94, 1588}, LandmarkSource::kDetected};
  face.pronasale = {{0, 113, 1550}, LandmarkSource::kDetected};
  return PlaceFrame(FindFrameStyle("example4").value(), face).value();
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(FrameJson, ReadsBackTheSameBits) {
  for (const FrameStyle& style : FrameStyles()) {
    const FrameParameters scaled = ScaledToWidth(style.parameters, 51.7 / 1.2);
    const auto read = FrameParametersFromJson(FrameParametersToJson(scaled, style.name), "FRAME.json");
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(*read, scaled);
  }
}

TEST(FrameJson, NamesTheFileAndTheKeyThatIsWrong) {
  const std::string good = FrameParametersToJson(FrameParameters{}, "round");
  const auto read = FrameParametersFromJson(Replaced(good, "\"height_mm\": 40.0", "\"height_mm\": \"tall\""), "F.json");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().Text(), HasSubstr("F.json"));
  EXPECT_THAT(read.error().Text(), HasSubstr("height_mm"));
  EXPECT_FALSE(FrameParametersFromJson(Replaced(good, "40.0", "1e400"), "F.json"));
  EXPECT_FALSE(FrameParametersFromJson(Replaced(good, "40.0", "400"), "F.json"));
  EXPECT_FALSE(FrameParametersFromJson(Replaced(good, "annulus-frame", "annulus-worn"), "F.json"));
  EXPECT_FALSE(FrameParametersFromJson(Replaced(good, "\"version\": 1", "\"version\": 2"), "F.json"));
}

TEST(FrameJson, RefusesEveryTruncation) {
  const std::string good = FrameParametersToJson(FrameParameters{}, "round");
  // The last two characters are the closing brace and the line feed.
  for (std::size_t length = 0; length + 2 <= good.size(); ++length) {
    EXPECT_FALSE(FrameParametersFromJson(good.substr(0, length), "F.json")) << length;
  }
}

TEST(FrameJson, RefusesForeignText) {
  for (const char* foreign : {"", "null", "[]", "{}", "level,z_mm", "\xff\xfe", "{\"format\": 3}", "[[[[[[[["}) {
    EXPECT_FALSE(FrameParametersFromJson(foreign, "F.json")) << foreign;
    EXPECT_FALSE(WornFrameFromJson(foreign, "W.json")) << foreign;
  }
  EXPECT_FALSE(FrameParametersFromJson(std::string(100000, '['), "F.json"));
}

TEST(WornJson, ReadsBackTheSameBits) {
  const WornFrame worn = Worn();
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
}

TEST(WornJson, RefusesEveryTruncation) {
  const std::string good = WornFrameToJson(Worn());
  for (std::size_t length = 0; length + 2 <= good.size(); length += 3) {
    EXPECT_FALSE(WornFrameFromJson(good.substr(0, length), "W.json")) << length;
  }
}

TEST(WornJson, RefusesWhatIsNoPlacement) {
  const std::string good = WornFrameToJson(Worn());
  EXPECT_FALSE(WornFrameFromJson(Replaced(good, "\"detected\"", "\"guessed\""), "W.json"));
  EXPECT_FALSE(WornFrameFromJson(Replaced(good, "\"rotation\"", "\"rotations\""), "W.json"));
  EXPECT_FALSE(WornFrameFromJson(Replaced(good, "\"tilt_rad\"", "\"tilt\""), "W.json"));
  EXPECT_FALSE(WornFrameFromJson(Replaced(good, "\"l6_left_mm\"", "\"l6\""), "W.json"));
  const auto sheared = WornFrameFromJson(Replaced(good, "0.965", "0.865"), "W.json");
  ASSERT_FALSE(sheared);
  EXPECT_THAT(sheared.error().Text(), HasSubstr("no rotation"));
}

}  // namespace
}  // namespace annulus
