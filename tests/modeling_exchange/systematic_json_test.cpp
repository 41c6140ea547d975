#include "modeling/exchange/systematic_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "modeling/exchange/model_json.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

/// A constant surface with both kinds of systematic errors.
SurfaceModel Model() {
  const PeriodicCubicBasis theta(5);
  const ClampedCubicBasis z({0.0, 10.0, 20.0});
  SurfaceModel model;
  model.segments.push_back({"body", {theta, z, Eigen::VectorXd::Constant(25, 80.0)}, {5, 3, 0.0, 20.0}, {}, {}, {}});
  model.systematic = SystematicErrors{CalibrationErrors{OffsetCovariance(6, 0.1, 0.3), 1e-4 / 3.0, 0.7},
                                      SwayErrors{2.7 / 3.0, 4.4, 120.0, {}, {}}};
  return model;
}

std::string SeenAfter(const std::function<void(Json&)>& change) {
  Json json = Json::parse(ModelToJson(Model()));
  change(json);
  const auto model = ModelFromJson(json.dump(), "m.json");
  return model ? std::string("accepted") : model.error().seen;
}

TEST(SystematicJson, ReadsBackToTheSameBits) {
  const SurfaceModel model = Model();
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again) << again.error().Text();
  ASSERT_TRUE(again->systematic && again->systematic->calibration && again->systematic->sway);
  const CalibrationErrors& calibration = *again->systematic->calibration;
  EXPECT_EQ(calibration.offset_covariance, model.systematic->calibration->offset_covariance);
  EXPECT_EQ(calibration.height_scale_sigma, 1e-4 / 3.0);
  EXPECT_EQ(calibration.height_offset_sigma, 0.7);
  EXPECT_EQ(again->systematic->sway->sigma_x, 2.7 / 3.0);
  EXPECT_EQ(again->systematic->sway->sigma_y, 4.4);
  EXPECT_EQ(again->systematic->sway->correlation_length, 120.0);
  EXPECT_EQ(ModelToJson(*again), text);
}

/// The same with the full form of a sway: three heights, a covariance of rank two.
SurfaceModel FullModel() {
  SurfaceModel model = Model();
  model.systematic->sway->heights = {0.0, 10.0 / 3.0, 20.0};
  Eigen::MatrixXd root(9, 2);
  for (Eigen::Index k = 0; k < 9; ++k)
    root.row(k) << 1.0 / (1.0 + static_cast<double>(k)), 0.1 * static_cast<double>(k);
  const Eigen::MatrixXd covariance = root * root.transpose();
  model.systematic->sway->covariance = 0.5 * (covariance + covariance.transpose());
  return model;
}

TEST(SystematicJson, ReadsAFullSwayBackToTheSameBits) {
  const SurfaceModel model = FullModel();
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again) << again.error().Text();
  ASSERT_TRUE(again->systematic && again->systematic->sway && again->systematic->sway->full());
  EXPECT_EQ(again->systematic->sway->heights, model.systematic->sway->heights);
  EXPECT_EQ(again->systematic->sway->covariance, model.systematic->sway->covariance);
  EXPECT_EQ(ModelToJson(*again), text);
}

TEST(SystematicJson, RefusesAFullSwayThatIsWrongByName) {
  const auto seen = [](const char* key, const Json& value) {
    Json json = Json::parse(ModelToJson(FullModel()));
    json["sway"][key] = value;
    const auto model = ModelFromJson(json.dump(), "m.json");
    return model ? std::string("accepted") : model.error().seen;
  };
  EXPECT_THAT(seen("heights_mm", Json{1.0, 2.0}), HasSubstr("does not hold 21 entries"));
  EXPECT_THAT(seen("heights_mm", Json{1.0}), HasSubstr("1 entries"));
  EXPECT_THAT(seen("heights_mm", Json{1.0, 3.0, 2.0}), HasSubstr("do not ascend"));
  EXPECT_THAT(seen("heights_mm", 7), HasSubstr("heights_mm"));
  EXPECT_THAT(seen("covariance", "AAAA"), HasSubstr("does not hold 45 entries"));
}

TEST(SystematicJson, WritesNullForWhatIsNotKnownAndTakesAnAbsentKeyForNull) {
  SurfaceModel model = Model();
  model.systematic->calibration.reset();
  Json json = Json::parse(ModelToJson(model));
  EXPECT_TRUE(json["calibration_covariance"].is_null());
  const auto swaying = ModelFromJson(json.dump(), "m.json");
  ASSERT_TRUE(swaying && swaying->systematic);
  EXPECT_FALSE(swaying->systematic->calibration);
  EXPECT_TRUE(swaying->systematic->sway);
  json["sway"] = nullptr;
  EXPECT_FALSE(ModelFromJson(json.dump(), "m.json")->systematic);
  json.erase("sway");
  json.erase("calibration_covariance");
  EXPECT_FALSE(ModelFromJson(json.dump(), "m.json")->systematic);
}

TEST(SystematicJson, RefusesWhatIsWrongByName) {
  const auto calibration = [](const char* key, const Json& value) {
    return SeenAfter([&](Json& json) { json["calibration_covariance"][key] = value; });
  };
  const auto sway = [](const char* key, const Json& value) {
    return SeenAfter([&](Json& json) { json["sway"][key] = value; });
  };
  EXPECT_THAT(calibration("directions", 7), HasSubstr("does not hold 28 entries"));
  EXPECT_THAT(calibration("directions", 0), HasSubstr("directions"));
  EXPECT_THAT(calibration("directions", 1e6), HasSubstr("directions"));
  EXPECT_THAT(calibration("offset_covariance_mm2", "AAAA"), HasSubstr("does not hold 21 entries"));
  EXPECT_THAT(calibration("offset_covariance_mm2", Json::array()), HasSubstr("offset_covariance_mm2"));
  EXPECT_THAT(calibration("height_scale_sigma", -1.0), HasSubstr("heights"));
  EXPECT_THAT(calibration("height_offset_sigma_mm", nullptr), HasSubstr("height_offset_sigma_mm"));
  EXPECT_THAT(sway("sigma_x_mm", -0.1), HasSubstr("sway"));
  EXPECT_THAT(sway("correlation_length_mm", 0.0), HasSubstr("correlation length"));
  EXPECT_THAT(sway("sigma_y_mm", "much"), HasSubstr("sigma_y_mm"));
  EXPECT_THAT(SeenAfter([](Json& json) { json["sway"] = 3; }), HasSubstr("sigma_x_mm"));
  EXPECT_THAT(SeenAfter([](Json& json) { json["calibration_covariance"] = "none"; }), HasSubstr("directions"));
  // A covariance of 3 mm² between two directions of variance 1 mm²: base64 of the doubles 1, 3, 1.
  EXPECT_THAT(SeenAfter([](Json& json) {
                json["calibration_covariance"]["directions"] = 2;
                json["calibration_covariance"]["offset_covariance_mm2"] = "AAAAAAAA8D8AAAAAAAAIQAAAAAAAAPA/";
              }),
              HasSubstr("not positive semi-definite"));
}

}  // namespace
}  // namespace annulus
