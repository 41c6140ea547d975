#include "modeling/exchange/model_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "fitting/fit_surface.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

/// A small tensor surface with a diagonal normal matrix, every number with all its bits in use.
SurfaceModel SmallModel() {
  std::mt19937_64 random(7);
  const PeriodicCubicBasis theta(7);
  const ClampedCubicBasis z({-10.1, 3.3, 20.7});
  Eigen::VectorXd c(static_cast<Eigen::Index>(theta.count() * z.count()));
  for (double& value : c) value = Uniform(random, 80.0, 120.0);
  c[0] = 100.0 / 3.0;
  c[1] = -0.0;
  c[2] = 5e-324;
  KnowledgeMap knowledge(5, 3, -10.1, 20.7);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 5; ++column) {
      knowledge.SetCell(column, row, static_cast<Knowledge>((row * 5 + column) % 3));
    }
  }
  Eigen::SparseMatrix<double> normal(c.size(), c.size());
  for (Eigen::Index k = 0; k < c.size(); ++k) {
    normal.insert(k, k) = Uniform(random, 1.0, 2.0);
    if (k >= 3) normal.insert(k - 3, k) = Uniform(random, -0.1, 0.1);
  }
  normal.makeCompressed();
  SurfaceModel model;
  model.segments.push_back({"body", {theta, z, c}, knowledge, normal, {}, {}});
  model.noise_sigma_mm = 0.1 + 0.2;
  model.provenance = {"sha256:00ff", "sha256:11", "0.1.0", "adaptive", 18'446'744'073'709'551'615ULL};
  return model;
}

/// A fitted surface with whatever refinement the fitter chose: a cylinder with a sharp bump.
SurfaceModel FittedModel() {
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < 40; ++level) {
    for (std::uint16_t sensor = 0; sensor < 60; ++sensor) {
      SurfaceSample sample;
      sample.theta = kTwoPi * sensor / 60.0;
      sample.z = 4.0 * level;
      const double d2 = std::pow((sample.theta - 2.0) * 100.0, 2) + std::pow(sample.z - 80.0, 2);
      sample.radius = 100.0 + 15.0 * std::exp(-d2 / 300.0) + 0.05 * std::sin(97.0 * level + 13.0 * sensor);
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  auto fit = FitSurface(samples, {}, {});
  if (!fit) throw std::runtime_error(fit.error().Text());
  return std::move(fit->model);
}

void ExpectSameBits(double a, double b) { EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)); }

void ExpectSameModel(const SurfaceModel& a, const SurfaceModel& b) {
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t k = 0; k < a.segments.size(); ++k) {
    const SurfaceSegment& x = a.segments[k];
    const SurfaceSegment& y = b.segments[k];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.surface.z_basis().breakpoints(), y.surface.z_basis().breakpoints());
    ASSERT_EQ(x.surface.coefficients().size(), y.surface.coefficients().size());
    for (Eigen::Index n = 0; n < x.surface.coefficients().size(); ++n) {
      ExpectSameBits(x.surface.coefficients()[n], y.surface.coefficients()[n]);
    }
    ASSERT_EQ(x.knowledge.columns(), y.knowledge.columns());
    ASSERT_EQ(x.knowledge.rows(), y.knowledge.rows());
    ExpectSameBits(x.knowledge.z_min(), y.knowledge.z_min());
    ExpectSameBits(x.knowledge.z_max(), y.knowledge.z_max());
    for (std::size_t row = 0; row < x.knowledge.rows(); ++row) {
      for (std::size_t column = 0; column < x.knowledge.columns(); ++column) {
        EXPECT_EQ(x.knowledge.Cell(column, row), y.knowledge.Cell(column, row));
      }
    }
    ASSERT_EQ(x.normal_matrix.nonZeros(), y.normal_matrix.nonZeros());
    EXPECT_EQ((x.normal_matrix - y.normal_matrix).norm(), 0.0);
    ExpectSameBits(x.detail_sigma, y.detail_sigma);
  }
  ExpectSameBits(a.noise_sigma_mm, b.noise_sigma_mm);
  EXPECT_EQ(a.provenance.recording_hash, b.provenance.recording_hash);
  EXPECT_EQ(a.provenance.calibration_hash, b.provenance.calibration_hash);
  EXPECT_EQ(a.provenance.program_version, b.provenance.program_version);
  EXPECT_EQ(a.provenance.method, b.provenance.method);
  EXPECT_EQ(a.provenance.seed, b.provenance.seed);
}

/// The error of a small model after `change` was done to its JSON; "" if it was accepted.
std::string ErrorAfter(const std::function<void(Json&)>& change) {
  Json json = Json::parse(ModelToJson(SmallModel()));
  change(json);
  const auto model = ModelFromJson(json.dump(), "m.json");
  return model ? std::string() : model.error().Text();
}

TEST(ModelJson, ReadsBackToTheSameBitsAndWritesTheSameBytes) {
  const SurfaceModel model = SmallModel();
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again.has_value()) << again.error().Text();
  ExpectSameModel(model, *again);
  EXPECT_EQ(ModelToJson(*again), text);
}

TEST(ModelJson, KeepsTheDetail) {
  SurfaceModel model = SmallModel();
  EXPECT_FALSE(Json::parse(ModelToJson(model))["surfaces"][0].contains("detail_sigma_mm"));
  model.segments.front().detail_sigma = 1.0 / 30.0;
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again.has_value()) << again.error().Text();
  ExpectSameModel(model, *again);
  EXPECT_EQ(ModelToJson(*again), text);
}

TEST(ModelJson, RefusesDetailThatIsNoLength) {
  for (const Json& wrong : {Json(-0.1), Json("much"), Json(nullptr), Json(1e10), Json(true)}) {
    EXPECT_THAT(ErrorAfter([&](Json& json) { json["surfaces"][0]["detail_sigma_mm"] = wrong; }),
                HasSubstr("detail_sigma_mm"))
        << wrong;
  }
}

TEST(ModelJson, ReadsAFittedModelBackToTheSameBits) {
  const SurfaceModel model = FittedModel();
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again.has_value()) << again.error().Text();
  ExpectSameModel(model, *again);
  EXPECT_EQ(ModelToJson(*again), text);
}

/// The small model with a second surface about an axis of its own.
SurfaceModel ModelWithALimb() {
  SurfaceModel model = SmallModel();
  model.segments.push_back(model.segments.front());
  model.segments.back().name = "left leg";
  model.segments.back().axis = {5.0, {-1.0 / 3.0, 12.5}, {0.1, -0.2}, {1e-4, -0.0}};
  return model;
}

TEST(ModelJson, KeepsTheAxisOfALimb) {
  const SurfaceModel model = ModelWithALimb();
  const std::string text = ModelToJson(model);
  const auto again = ModelFromJson(text, "m.json");
  ASSERT_TRUE(again.has_value()) << again.error().Text();
  ExpectSameModel(model, *again);
  EXPECT_TRUE(again->main().axis.IsRingAxis());
  const SegmentAxis& read = again->segments.back().axis;
  const SegmentAxis& written = model.segments.back().axis;
  ExpectSameBits(read.z_middle, written.z_middle);
  for (Eigen::Index k = 0; k < 2; ++k) {
    ExpectSameBits(read.at[k], written.at[k]);
    ExpectSameBits(read.slope[k], written.slope[k]);
    ExpectSameBits(read.bend[k], written.bend[k]);
  }
  EXPECT_EQ(ModelToJson(*again), text);
}

TEST(ModelJson, RefusesAnAxisThatMakesNoSense) {
  const auto error_after = [](const std::function<void(Json&)>& change) {
    Json json = Json::parse(ModelToJson(ModelWithALimb()));
    change(json["surfaces"]);
    const auto model = ModelFromJson(json.dump(), "m.json");
    return model ? std::string() : model.error().Text();
  };
  EXPECT_EQ(error_after([](Json&) {}), "");
  EXPECT_NE(error_after([](Json& s) { s[1]["axis"].erase("x_slope"); }).find("x_slope"), std::string::npos);
  EXPECT_NE(error_after([](Json& s) { s[1]["axis"]["y_mm"] = "far"; }).find("y_mm"), std::string::npos);
  EXPECT_NE(error_after([](Json& s) { s[1]["axis"]["x_slope"] = 1e9; }).find("axis"), std::string::npos);
  EXPECT_NE(error_after([](Json& s) { s[1]["axis"]["x_bend_per_mm"] = 1e300; }), "");
  EXPECT_NE(error_after([](Json& s) { s[1]["axis"] = 7; }), "");
  EXPECT_NE(error_after([](Json& s) { s[0]["axis"] = s[1]["axis"]; }).find("first surface"), std::string::npos);
}

TEST(ModelJson, MayLeaveTheNormalMatrixOut) {
  SurfaceModel model = SmallModel();
  model.segments.front().normal_matrix = {};
  const auto again = ModelFromJson(ModelToJson(model), "m.json");
  ASSERT_TRUE(again.has_value()) << again.error().Text();
  EXPECT_EQ(again->main().normal_matrix.nonZeros(), 0);
}

TEST(ModelJson, SkipsKeysThatItDoesNotKnow) {
  EXPECT_EQ(ErrorAfter([](Json& json) {
              json["later"] = {1, 2, 3};
              json["surfaces"][0]["colour"] = "blue";
            }),
            "");
}

TEST(ModelJson, RefusesATextThatWasCutAnywhere) {
  const std::string text = ModelToJson(SmallModel());
  const std::size_t end = text.find_last_of('}');
  for (std::size_t size = 0; size <= end; size += size < 200 || size > end - 200 ? 1 : 17) {
    const auto model = ModelFromJson(text.substr(0, size), "m.json");
    ASSERT_FALSE(model.has_value()) << size;
    EXPECT_THAT(model.error().Text(), HasSubstr("read model m.json"));
  }
}

TEST(ModelJson, RefusesWhateverMemberIsMissingOrOfAnotherKind) {
  const Json whole = Json::parse(ModelToJson(SmallModel()));
  const std::vector<Json> replacements{nullptr, true, -1, 1.5, "text", Json::array(), Json::object(), {nullptr}};
  const auto check = [&](const std::string& pointer) {
    for (const Json& other : replacements) {
      Json changed = whole;
      changed[Json::json_pointer(pointer)] = other;
      // Only "no crash, one line" holds for every replacement; some are legal (a text for a text).
      const auto model = ModelFromJson(changed.dump(), "m.json");
      EXPECT_EQ(model ? std::string::npos : model.error().Text().find('\n'), std::string::npos);
    }
    Json changed = whole;
    const auto cut = pointer.find_last_of('/');
    changed[Json::json_pointer(pointer.substr(0, cut))].erase(pointer.substr(cut + 1));
    return ModelFromJson(changed.dump(), "m.json").has_value();
  };
  for (const char* needed : {"/format",
                             "/version",
                             "/provenance",
                             "/provenance/seed",
                             "/provenance/method",
                             "/noise_sigma_mm",
                             "/surfaces",
                             "/measured",
                             "/normal_matrix",
                             "/surfaces/0/name",
                             "/surfaces/0/theta_count",
                             "/surfaces/0/z_breakpoints_mm",
                             "/surfaces/0/coefficients_mm",
                             "/measured/0/columns",
                             "/measured/0/rows",
                             "/measured/0/z_min_mm",
                             "/measured/0/z_max_mm",
                             "/normal_matrix/0/size",
                             "/normal_matrix/0/entries",
                             "/normal_matrix/0/row_start",
                             "/normal_matrix/0/column",
                             "/normal_matrix/0/value"}) {
    EXPECT_FALSE(check(needed)) << needed;
  }
}

TEST(ModelJson, RefusesSizesThatDoNotAgree) {
  EXPECT_THAT(ErrorAfter([](Json& json) { json["surfaces"][0]["coefficients_mm"].erase(0); }),
              HasSubstr("coefficients_mm"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["surfaces"][0]["theta_count"] = 8; }), HasSubstr("coefficients_mm"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["surfaces"][0]["z_breakpoints_mm"] = {1.0}; }),
              HasSubstr("z_breakpoints_mm"));
  EXPECT_THAT(ErrorAfter([](Json& json) {
                json["surfaces"][0]["z_breakpoints_mm"] = {1.0, 1.0, 2.0};
              }),
              HasSubstr("does not increase"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["measured"][0]["rows"][1] = "uim"; }), HasSubstr("another length"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["measured"][0]["rows"][1] = "uimux"; }), HasSubstr("something else"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["measured"][0]["z_max_mm"] = -99.0; }), HasSubstr("z_min_mm"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["measured"].push_back(json["measured"][0]); }), HasSubstr("measured"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["surfaces"] = Json::array(); }), HasSubstr("surfaces"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["normal_matrix"][0]["size"] = 3; }), HasSubstr("normal_matrix"));
  EXPECT_THAT(ErrorAfter([](Json& json) { json["normal_matrix"][0]["entries"] = 3; }), HasSubstr("normal_matrix"));
}

TEST(ModelJson, RefusesANormalMatrixWhoseIndicesLeaveIt) {
  // int32 0xffffffff = -1 and 0x7fffffff, little-endian, in place of the first entries.
  for (const char* first : {"/////w", "/////3"}) {
    for (const char* key : {"row_start", "column"}) {
      EXPECT_NE(ErrorAfter([&](Json& json) {
                  auto text = json["normal_matrix"][0][key].get<std::string>();
                  text.replace(0, 5, std::string(first).substr(0, 5));
                  json["normal_matrix"][0][key] = text;
                }),
                "")
          << key;
    }
  }
}

TEST(ModelJson, RefusesNumbersThatAreNotFinite) {
  const std::string text = ModelToJson(SmallModel());
  const auto with_noise = [&](const std::string& number) {
    std::string changed = text;
    const std::size_t key = changed.find("\"noise_sigma_mm\": ");
    const std::size_t from = key + std::string("\"noise_sigma_mm\": ").size();
    changed.replace(from, changed.find(',', from) - from, number);
    return ModelFromJson(changed, "m.json");
  };
  ASSERT_TRUE(with_noise("0.25").has_value());
  for (const char* number : {"NaN", "Infinity", "-Infinity", "nan", "1e999", "-1e999", "null", "\"0.25\"", "1e300"}) {
    const auto model = with_noise(number);
    ASSERT_FALSE(model.has_value()) << number;
    EXPECT_THAT(model.error().Text(), HasSubstr("read model m.json")) << number;
  }
  EXPECT_NE(ErrorAfter([](Json& json) { json["surfaces"][0]["coefficients_mm"][3] = nullptr; }), "");
}

TEST(ModelJson, RefusesANewerVersionAndAnotherFormat) {
  EXPECT_THAT(ErrorAfter([](Json& json) { json["version"] = json["version"].get<int>() + 1; }), HasSubstr("newer"));
  EXPECT_NE(ErrorAfter([](Json& json) { json["version"] = 0; }), "");
  EXPECT_NE(ErrorAfter([](Json& json) { json["format"] = "annulus-frame"; }), "");
  for (const char* text : {"", "[]", "null", "1", "\"annulus-model\"", "{}", "PK\x03\x04", "\xff\xfe"}) {
    EXPECT_FALSE(ModelFromJson(text, "m.json").has_value()) << text;
  }
}

TEST(ModelJson, RefusesDeepNestingWithoutCrashing) {
  const std::size_t deep = 1'000'000;
  EXPECT_FALSE(ModelFromJson(std::string(deep, '['), "m.json").has_value());
  EXPECT_FALSE(ModelFromJson(std::string(deep, '[') + std::string(deep, ']'), "m.json").has_value());
  std::string objects;
  for (std::size_t k = 0; k < deep / 10; ++k) objects += "{\"a\":";
  EXPECT_FALSE(ModelFromJson(objects, "m.json").has_value());
  EXPECT_FALSE(ModelFromJson(objects + "1" + std::string(deep / 10, '}'), "m.json").has_value());
}

TEST(ModelJson, DoesNotTakeMemoryThatTheFileDoesNotPayFor) {
  // 100,000 columns announced, 200,000 empty rows: 20 GB if the map were made before its rows were looked at.
  EXPECT_NE(ErrorAfter([](Json& json) {
              json["measured"][0]["columns"] = 100'000;
              json["measured"][0]["rows"] = std::vector<std::string>(200'000);
            }),
            "");
  EXPECT_NE(ErrorAfter([](Json& json) { json["surfaces"][0]["theta_count"] = 100'000; }), "");
  EXPECT_NE(ErrorAfter([](Json& json) { json["normal_matrix"][0]["size"] = 16'000'000; }), "");
}

TEST(ModelJson, RefusesKnotsTooCloseToBeHalved) {
  EXPECT_NE(ErrorAfter([](Json& json) {
              Json& surface = json["surfaces"][0];
              surface["z_breakpoints_mm"] = {1.0, std::nextafter(1.0, 2.0)};
              surface["refined"] = {{std::string(7, '1')}};
            }),
            "");
  EXPECT_NE(ErrorAfter([](Json& json) { json["surfaces"][0]["z_breakpoints_mm"] = {-1e308, 0.0, 1e308}; }), "");
}

TEST(ModelJson, WritesNoBytesThatAreNotUtf8) {
  SurfaceModel model = SmallModel();
  model.provenance.recording_hash = "sha256:\xff\xfe";
  const std::string text = ModelToJson(model);
  EXPECT_TRUE(ModelFromJson(text, "m.json").has_value());
}

}  // namespace
}  // namespace annulus
