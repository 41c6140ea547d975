#include "modeling/landmarks/landmark_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/units.h"
#include "modeling/landmarks/landmarks.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using testing::HasSubstr;

/// A cone of radius 50 + z/10, z from 0 to 400; unseen below 100 mm except on the front half.
SurfaceModel Cone() {
  SurfaceModel model =
      test::InterpolatedBody([](double, double z) { return 50.0 + 0.1 * z; }, 24, UniformBreakpoints(0.0, 400.0, 20));
  KnowledgeMap& map = model.segments.front().knowledge;
  for (std::size_t row = 0; row < map.rows() / 4; ++row) {
    for (std::size_t column = map.columns() / 2 - 2; column < map.columns(); ++column) {
      map.SetCell(column, row, Knowledge::kUnknown);
    }
  }
  return model;
}

class SetByHandTest : public testing::Test {
 protected:
  SurfaceModel model_ = Cone();
  MeasuredSurface body_ = *MeasuredSurface::FromModel(model_);

  std::string ErrorOf(const GivenLandmark& given) const {
    const auto result = SetByHand(body_, {}, given);
    return result ? "" : result.error().Text();
  }
};

TEST_F(SetByHandTest, PutsAPointOnTheSurface) {
  const auto set = SetByHand(body_, {}, {"neck_front", kPi / 2.0 + 2.0 * kTwoPi, 200.0, 3.0});
  ASSERT_TRUE(set.has_value()) << set.error().Text();
  const Landmark* point = set->Find("neck_front");
  ASSERT_NE(point, nullptr);
  EXPECT_EQ(point->source, LandmarkSource::kGiven);
  EXPECT_EQ(point->confidence, 1.0);
  EXPECT_NEAR(point->theta.value, kPi / 2.0, 1e-12);
  EXPECT_LT((point->position - Eigen::Vector3d(0.0, 70.0, 200.0)).norm(), 1e-9);
  EXPECT_EQ(point->placing_across, 3.0);
  EXPECT_EQ(point->placing_up, 3.0);
  EXPECT_EQ(point->z.gradient.size(), 0);
}

TEST_F(SetByHandTest, ReplacesWhatWasFoundAndTheSentenceThatItWasNot) {
  Landmarks found;
  found.found = {*std::move(SetByHand(body_, {}, {"level.hip", std::nullopt, 150.0}))->Find("level.hip")};
  found.front = 1.25;  // where the subject stands does not change
  found.omitted = {"Natural waist level: not seen.", "Crotch level: not seen."};
  auto set = SetByHand(body_, found, {"level.waist", std::nullopt, 300.0});
  ASSERT_TRUE(set.has_value());
  EXPECT_EQ(set->front, 1.25);
  set = SetByHand(body_, *set, {"level.hip", std::nullopt, 160.0});
  ASSERT_TRUE(set.has_value());
  ASSERT_EQ(set->found.size(), 2U);
  EXPECT_EQ(set->found[0].id, "level.waist");  // in the order of all landmarks
  EXPECT_EQ(set->found[1].z.value, 160.0);
  EXPECT_EQ(set->found[1].placing_up, kPlacingByHand);
  EXPECT_THAT(set->omitted, testing::ElementsAre("Crotch level: not seen."));
}

TEST_F(SetByHandTest, NamesTheIdsThatAreLikeAnUnknownOne) {
  EXPECT_THAT(ErrorOf({"level.waste", std::nullopt, 200.0}), HasSubstr("level.waist"));
  EXPECT_THAT(ErrorOf({"waist", std::nullopt, 200.0}), HasSubstr("level.waist"));
  EXPECT_THAT(ErrorOf({std::string(100000, 'x'), std::nullopt, 200.0}), HasSubstr("the closest are"));
  EXPECT_THAT(ErrorOf({"", std::nullopt, 200.0}), HasSubstr("no landmark has this id"));
}

TEST_F(SetByHandTest, RefusesWhatIsNoPlaceOnTheData) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ErrorOf({"level.waist", std::nullopt, kNan}), HasSubstr("finite"));
  EXPECT_THAT(ErrorOf({"neck_front", kInfinity, 200.0}), HasSubstr("finite"));
  EXPECT_THAT(ErrorOf({"level.waist", std::nullopt, 401.0}), HasSubstr("400"));
  EXPECT_THAT(ErrorOf({"neck_front", std::nullopt, 200.0}), HasSubstr("theta"));
  EXPECT_THAT(ErrorOf({"level.waist", 1.0, 200.0}), HasSubstr("no theta"));
  EXPECT_THAT(ErrorOf({"neck_back", -kPi / 2.0, 50.0}), HasSubstr("did not see"));
  EXPECT_THAT(ErrorOf({"level.hip", std::nullopt, 50.0}), HasSubstr("less than half"));
  EXPECT_THAT(ErrorOf({"level.hip", std::nullopt, 200.0, -1.0}), HasSubstr("sd"));
  EXPECT_THAT(ErrorOf({"level.hip", std::nullopt, 200.0, kNan}), HasSubstr("sd"));
  EXPECT_EQ(ErrorOf({"neck_front", kPi / 2.0, 50.0}), "");
}

TEST(AllLandmarks, HaveIdsOfTheirOwnTermsAndDefinitions) {
  std::vector<std::string> ids;
  for (const Landmark& landmark : AllLandmarks()) {
    EXPECT_FALSE(landmark.term.empty() || landmark.definition.empty()) << landmark.id;
    EXPECT_THAT(ids, testing::Not(testing::Contains(landmark.id)));
    const bool is_level = landmark.id.starts_with("level.") || landmark.id == "vertex";
    EXPECT_EQ(landmark.kind == LandmarkKind::kLevel, is_level) << landmark.id;
    ids.push_back(landmark.id);
  }
  EXPECT_GE(ids.size(), 30U);
}

}  // namespace
}  // namespace annulus
