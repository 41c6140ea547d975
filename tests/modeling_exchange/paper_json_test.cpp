#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/frames.h"
#include "fitting/paper_model.h"
#include "modeling/exchange/model_json.h"
#include "modeling/measure/section.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

PaperDirection Direction(std::size_t features, double from, double step, double period) {
  PaperDirection direction;
  direction.place = 1.0 / 3.0;
  direction.complexity = {features, 123.456};
  direction.noise_sd = 0.5;
  direction.gate = 3.6;
  direction.lambda = 1.0 / 7e6;
  direction.effective = 17.25;
  direction.cost_by_rule = 88.0;
  direction.cost_moved = 80.5;
  direction.iterations = 12;
  direction.plan.period = period;
  direction.plan.evened = 0.625;
  direction.plan.dropped = 2;
  for (std::size_t k = 0; k < features; ++k) {
    const auto kind = static_cast<FeatureKind>(k % 4);
    direction.plan.features.push_back({kind, from + step * static_cast<double>(3 * k), 4.0 + static_cast<double>(k)});
  }
  for (std::size_t k = 0; k < 3 * features - (period > 0.0 ? 0 : 2); ++k) {
    direction.plan.knots.push_back(k % 3 == 0 ? direction.plan.features[k / 3].x
                                              : from + step * (static_cast<double>(k) + 0.1));
  }
  return direction;
}

SurfaceModel PaperBody() {
  PaperFitReport report{Direction(4, 0.05, kTwoPi / 12.0, kTwoPi), Direction(3, -10.0, 15.0, 0.0), 40, 3, 1};
  const std::vector<double> theta = report.around.plan.knots;
  const std::vector<double> z = report.along.plan.knots;
  Eigen::MatrixXd radius(static_cast<Eigen::Index>(z.size()), static_cast<Eigen::Index>(theta.size()));
  for (Eigen::Index j = 0; j < radius.rows(); ++j) {
    for (Eigen::Index i = 0; i < radius.cols(); ++i) {
      radius(j, i) = 100.0 + 10.0 * std::cos(2.0 * theta[static_cast<std::size_t>(i)]) + static_cast<double>(j) / 3.0;
    }
  }
  auto surface = PaperSurface::Through(theta, z, radius);
  EXPECT_TRUE(surface.has_value());
  SplineSurface tensor = ApproximateByTensor(*surface).surface;
  auto paper = std::make_shared<const PaperModel>(PaperModel{std::move(*surface), std::move(report)});
  SurfaceModel model;
  KnowledgeMap known(36, 10, -10.0, 80.0);
  for (std::size_t row = 0; row < 10; ++row) {
    for (std::size_t column = 0; column < 36; ++column) known.SetCell(column, row, Knowledge::kMeasured);
  }
  model.segments.push_back({"body", std::move(tensor), std::move(known), {}, {}, {}, std::move(paper)});
  model.noise_sigma_mm = 0.5;
  model.provenance.method = "paper";
  return model;
}

TEST(PaperJson, ReadsBackToTheSameBits) {
  const SurfaceModel model = PaperBody();
  const std::string written = ModelToJson(model);
  const auto read = ModelFromJson(written, "model.json");
  ASSERT_TRUE(read.has_value()) << read.error().Text();
  const PaperModel& before = *model.main().paper;
  ASSERT_NE(read->main().paper, nullptr);
  const PaperModel& after = *read->main().paper;
  ASSERT_EQ(after.surface.control().size(), before.surface.control().size());
  EXPECT_EQ(std::memcmp(after.surface.control().data(), before.surface.control().data(),
                        before.surface.control().size() * sizeof(Eigen::Vector3d)),
            0);
  EXPECT_EQ(after.surface.theta_knots(), before.surface.theta_knots());
  EXPECT_EQ(after.surface.z_knots(), before.surface.z_knots());
  EXPECT_EQ(after.report.around.lambda, before.report.around.lambda);
  EXPECT_EQ(after.report.along.complexity, before.report.along.complexity);
  EXPECT_EQ(after.report.around.plan.features[1].kind, FeatureKind::kInflection);
  EXPECT_EQ(read->main().surface.coefficients(), model.main().surface.coefficients());  // the tensor form, made anew
  EXPECT_EQ(ModelToJson(*read), written);
}

TEST(PaperJson, IsEvaluatedOnTheSurfaceItself) {
  const SurfaceModel model = PaperBody();
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body.has_value());
  const PaperSurface& surface = model.main().paper->surface;
  EXPECT_EQ(body->Radius(1.234, 22.0), surface.Radius(1.234, 22.0));
  EXPECT_EQ(body->Point(1.234, 22.0), surface.Point(1.234, 22.0));
  EXPECT_EQ(body->Normal(1.234, 22.0), surface.Normal(1.234, 22.0));
  EXPECT_NEAR(body->surface().Radius(1.234, 22.0), surface.Radius(1.234, 22.0), 0.01);
  EXPECT_TRUE(std::isnan(body->RadiusSigma(1.234, 22.0)));
  EXPECT_TRUE(MeasureSection(*body, 22.0).has_value());
}

/// One change to a good file that makes it a bad one.
struct Change {
  const char* name;
  const char* pointer;
  const char* value;
};

class BadPaperJson : public testing::TestWithParam<Change> {};

TEST_P(BadPaperJson, IsRefused) {
  Json json = Json::parse(ModelToJson(PaperBody()));
  json[Json::json_pointer(std::string("/surfaces/0/paper/") + GetParam().pointer)] = Json::parse(GetParam().value);
  const auto read = ModelFromJson(json.dump(), "model.json");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().Text().find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadPaperJson,
    testing::Values(Change{"PointWithTwoCoordinates", "control_points_mm/5", "[1, 2]"},
                    Change{"PointOfText", "control_points_mm/5", "[1, 2, \"3\"]"},
                    Change{"PointsAreNoList", "control_points_mm", "7"}, Change{"NoPoints", "control_points_mm", "[]"},
                    Change{"PointFarAway", "control_points_mm/5", "[1e9, 0, 0]"},
                    Change{"HeightDiffersInARow", "control_points_mm/5/2", "-3"},
                    Change{"FoldedSection", "control_points_mm/30/0", "-9000"},
                    Change{"KnotOutOfOrder", "around/knots_rad/4", "0"},
                    Change{"KnotOfText", "around/knots_rad/4", "\"a\""},
                    Change{"TooFewKnots", "along/knots_mm", "[0, 1]"},
                    Change{"FeatureOffItsKnot", "around/features/1/theta_rad", "0.1"},
                    Change{"UnknownKind", "around/features/1/kind", "\"bump\""},
                    Change{"NoFeatures", "along/features", "[]"}, Change{"LambdaMissing", "around/lambda_rad3", "null"},
                    Change{"NegativeCount", "levels", "-1"}, Change{"DirectionIsNoObject", "along", "[]"}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace annulus
