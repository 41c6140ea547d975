#include "modeling/exchange/landmarks_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using testing::HasSubstr;

class LandmarksJson : public testing::Test {
 protected:
  SurfaceModel model_ =
      test::InterpolatedBody([](double, double z) { return 50.0 + 0.1 * z; }, 24, UniformBreakpoints(0.0, 400.0, 20));
  MeasuredSurface body_ = *MeasuredSurface::FromModel(model_);

  std::string ErrorOf(const std::string& json) const {
    const auto given = GivenLandmarksFromJson(json, "f.json");
    return given ? "" : given.error().Text();
  }
};

TEST_F(LandmarksJson, ReadsBackWhatWasGivenToTheBit) {
  Landmarks landmarks = *SetByHand(body_, {}, {"neck_front", 1.2345678901234567, 200.1, 3.5});
  landmarks = *SetByHand(body_, landmarks, {"level.waist", std::nullopt, 0.1 + 0.2});
  Landmark detected = *landmarks.Find("level.waist");
  detected.id = "level.hip";
  detected.source = LandmarkSource::kDetected;
  landmarks.found.push_back(detected);
  const std::string json = LandmarksToJson(body_, landmarks);
  const auto given = GivenLandmarksFromJson(json, "f.json");
  ASSERT_TRUE(given.has_value()) << given.error().Text();
  ASSERT_EQ(given->size(), 2U);  // the detected one is found again, not read
  EXPECT_EQ((*given)[0].id, "neck_front");
  EXPECT_EQ((*given)[0].theta, 1.2345678901234567);
  EXPECT_EQ((*given)[0].z, 200.1);
  EXPECT_EQ((*given)[0].placing, 3.5);
  EXPECT_EQ((*given)[1].theta, std::nullopt);
  EXPECT_EQ((*given)[1].z, 0.1 + 0.2);

  const auto applied = ApplyLandmarksFile(body_, {}, json, "f.json");
  ASSERT_TRUE(applied.has_value());
  ASSERT_EQ(applied->found.size(), 2U);
  landmarks.found.pop_back();
  EXPECT_EQ(LandmarksToJson(body_, *applied), LandmarksToJson(body_, landmarks));
}

TEST_F(LandmarksJson, NamesTheFileWhoseLandmarkDoesNotFitTheModel) {
  const Landmarks landmarks = *SetByHand(body_, {}, {"level.waist", std::nullopt, 390.0});
  const SurfaceModel shorter =
      test::InterpolatedBody([](double, double) { return 50.0; }, 24, UniformBreakpoints(0.0, 300.0, 20));
  const auto applied =
      ApplyLandmarksFile(*MeasuredSurface::FromModel(shorter), {}, LandmarksToJson(body_, landmarks), "f.json");
  ASSERT_FALSE(applied.has_value());
  EXPECT_THAT(applied.error().Text(), testing::AllOf(HasSubstr("f.json"), HasSubstr("level.waist"), HasSubstr("300")));
}

TEST_F(LandmarksJson, RefusesWhatIsNoLandmarksFileInOneLine) {
  const std::string begin = R"({"format": "annulus-landmarks", "version": 1, "given": )";
  EXPECT_THAT(ErrorOf(""), HasSubstr("not JSON"));
  EXPECT_THAT(ErrorOf("[]"), HasSubstr("f.json"));
  EXPECT_THAT(ErrorOf(R"({"format": "annulus-model", "version": 1})"), HasSubstr("format"));
  EXPECT_THAT(ErrorOf(R"({"format": "annulus-landmarks", "version": 2, "given": []})"), HasSubstr("version"));
  EXPECT_THAT(ErrorOf(begin + "3}"), HasSubstr("given"));
  EXPECT_THAT(ErrorOf(begin + "[3]}"), HasSubstr("id"));
  EXPECT_THAT(ErrorOf(begin + R"([{"id": "level.hip"}]})"), HasSubstr("z_mm"));
  EXPECT_THAT(ErrorOf(begin + R"([{"id": "level.hip", "z_mm": 1e999, "placing_sigma_mm": 2}]})"), HasSubstr("f.json"));
  EXPECT_THAT(ErrorOf(begin + R"([{"id": "level.hip", "z_mm": 1, "placing_sigma_mm": "2"}]})"),
              HasSubstr("placing_sigma_mm"));
  const std::string hip = R"({"id": "level.hip", "z_mm": 1, "placing_sigma_mm": 2})";
  EXPECT_THAT(ErrorOf(begin + "[" + hip + "," + hip + "]}"), HasSubstr("twice"));
  EXPECT_EQ(ErrorOf(begin + "[" + hip + "]}"), "");
  EXPECT_THAT(ErrorOf(std::string(100000, '[')), HasSubstr("not JSON"));
}

}  // namespace
}  // namespace annulus
