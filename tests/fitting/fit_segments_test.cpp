#include "fitting/fit_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "tests/fitting/ring_scene.h"

namespace annulus {
namespace {

using test::Column;
using test::RingScene;

const SurfaceSegment* Find(const SurfaceModel& model, const std::string& name) {
  const auto found = std::find_if(model.segments.begin(), model.segments.end(),
                                  [&](const SurfaceSegment& segment) { return segment.name == name; });
  return found == model.segments.end() ? nullptr : &*found;
}

const SectionRegion* Region(const FitSummary& summary, const std::string& name) {
  const auto found = std::find_if(summary.regions.begin(), summary.regions.end(),
                                  [&](const SectionRegion& region) { return region.name == name; });
  return found == summary.regions.end() ? nullptr : &*found;
}

/// Distance of a point from the outline of a column's section, mm, along the ray from its centre.
double OffOutline(const Column& column, const Eigen::Vector3d& point) {
  const Eigen::Vector2d d(point.x() - column.CentreX(point.z()), point.y() - column.CentreY(point.z()));
  const double scale = std::hypot(d.x() / column.half_width, d.y() / column.half_depth);
  return d.norm() * (1.0 - 1.0 / scale);
}

/// RMS distance, mm, of a segment's known cells from a column, and how many there are.
struct Accuracy {
  double rms = 0.0;
  std::size_t cells = 0;
};

Accuracy AccuracyOf(const SurfaceSegment& segment, const Column& column) {
  Accuracy accuracy;
  const KnowledgeMap& map = segment.knowledge;
  double squares = 0.0;
  for (std::size_t row = 2; row + 2 < map.rows(); ++row) {
    const double z =
        map.z_min() + (static_cast<double>(row) + 0.5) * (map.z_max() - map.z_min()) / static_cast<double>(map.rows());
    for (std::size_t c = 0; c < map.columns(); ++c) {
      if (map.Cell(c, row) == Knowledge::kUnknown) continue;
      const double theta = kTwoPi * static_cast<double>(c) / static_cast<double>(map.columns());
      squares += std::pow(OffOutline(column, segment.Point(theta, z)), 2);
      ++accuracy.cells;
    }
  }
  accuracy.rms = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, accuracy.cells)));
  return accuracy;
}

/// Every sample is either used by one segment or listed as rejected.
void ExpectAllSamplesAccountedFor(const FitResult& fit, std::size_t samples) {
  const FitSummary& summary = fit.summary;
  EXPECT_EQ(summary.samples, samples);
  EXPECT_EQ(summary.used + summary.rejected.size(), samples);
  std::set<std::size_t> rejected;
  for (const RejectedSample& sample : summary.rejected) rejected.insert(sample.index);
  EXPECT_EQ(rejected.size(), summary.rejected.size()) << "a sample is rejected twice";
  ASSERT_EQ(summary.segment_of_sample.size(), samples);
  for (std::size_t k = 0; k < samples; ++k) {
    const bool none = summary.segment_of_sample[k] == FitSummary::kNoSegment;
    EXPECT_EQ(none, rejected.contains(k)) << "sample " << k;
    EXPECT_TRUE(none || summary.segment_of_sample[k] < fit.model.segments.size());
  }
}

RingScene Noisy(RingScene scene) {
  scene.noise = 0.4;
  scene.dropouts = 0.01;
  scene.outliers = 0.002;
  return scene;
}

TEST(FitBody, IsFitSurfaceToTheBitWhereTheBodyIsOneLoop) {
  const auto samples =
      test::SyntheticScan(test::SmoothTrunk, {.levels = 60, .sensors = 90, .pitch = 5.0, .noise = 0.5});
  const auto plain = FitSurface(samples, {}, {});
  const auto body = FitBody(samples, {}, {});
  ASSERT_TRUE(plain.has_value() && body.has_value());
  ASSERT_EQ(body->model.segments.size(), 1U);
  EXPECT_TRUE(body->model.main().axis.IsRingAxis());
  EXPECT_TRUE(body->model.main().surface.coefficients() == plain->model.main().surface.coefficients());
  EXPECT_TRUE(body->model.main().active == plain->model.main().active);
  EXPECT_EQ((body->model.main().normal_matrix - plain->model.main().normal_matrix).norm(), 0.0);
  EXPECT_TRUE(body->summary.regions.empty());
  EXPECT_TRUE(body->summary.segment_of_sample.empty());
  EXPECT_EQ(body->summary.used, plain->summary.used);
}

TEST(FitBody, GivesEachLegASurfaceAndTheTrunkNoneOfIt) {
  const RingScene scene = Noisy(test::TrunkOnLegs());
  const auto samples = scene.Scan();
  const auto fit = FitBody(samples, {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ASSERT_EQ(fit->model.segments.size(), 3U);
  const SurfaceSegment& trunk = fit->model.main();
  EXPECT_EQ(trunk.name, "body");
  EXPECT_GT(trunk.surface.z_min(), test::kCrotch);
  EXPECT_LT(AccuracyOf(trunk, scene.columns[0]).rms, 0.3);
  for (double z = 0.0; z < test::kCrotch - scene.pitch; z += 50.0) {
    for (double theta = 0.0; theta < 6.2; theta += 0.1) EXPECT_EQ(trunk.knowledge.At(theta, z), Knowledge::kUnknown);
  }
  const std::array<std::string, 2> names{"right leg", "left leg"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SurfaceSegment* leg = Find(fit->model, names[k]);
    ASSERT_NE(leg, nullptr) << names[k];
    EXPECT_NEAR(leg->surface.z_min(), 0.0, 1e-9);
    EXPECT_NEAR(leg->surface.z_max(), 805.0, 1e-9);  // the trunk's lowest level: the two meet
    const Accuracy accuracy = AccuracyOf(*leg, scene.columns[k + 1]);
    EXPECT_LT(accuracy.rms, 0.5) << names[k];
    EXPECT_GT(accuracy.cells, 0.5 * static_cast<double>(leg->knowledge.columns() * leg->knowledge.rows()));
  }
  const SectionRegion* legs = Region(fit->summary, "legs");
  ASSERT_NE(legs, nullptr);
  EXPECT_NE(legs->outcome.find("fitted as segment right leg"), std::string::npos) << legs->outcome;
  ExpectAllSamplesAccountedFor(*fit, samples.size());
}

TEST(FitBody, DoesNotGuessTheSideOfALegThatNoSensorSees) {
  const RingScene scene = Noisy(test::TrunkOnLegs());
  const auto fit = FitBody(scene.Scan(), {}, {});
  ASSERT_TRUE(fit.has_value());
  const SurfaceSegment* leg = Find(fit->model, "right leg");
  ASSERT_NE(leg, nullptr);
  // Rays to the axis touch a circle of radius 80 mm, 95 mm away, no nearer than sqrt(95² - 80²) = 51 mm: the point
  // that faces the axis, 20 mm from it, is far from all that was seen.
  for (double z = 100.0; z < 700.0; z += 50.0) {
    const Eigen::Vector2d inward = Eigen::Vector2d(20.0, 0.0) - leg->axis.At(z);
    EXPECT_EQ(leg->knowledge.At(WrapAngle(std::atan2(inward.y(), inward.x())), z), Knowledge::kUnknown) << z;
    const Eigen::Vector2d outward = Eigen::Vector2d(170.0, 0.0) - leg->axis.At(z);
    EXPECT_EQ(leg->knowledge.At(WrapAngle(std::atan2(outward.y(), outward.x())), z), Knowledge::kMeasured) << z;
  }
}

class FitBodyArms : public testing::TestWithParam<double> {};

TEST_P(FitBodyArms, LeaveTheTrunkAndHaveSurfacesOfTheirOwn) {
  const RingScene scene = Noisy(test::TrunkWithArms(GetParam()));
  const auto samples = scene.Scan();
  const auto fit = FitBody(samples, {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  EXPECT_LT(AccuracyOf(fit->model.main(), scene.columns[0]).rms, 0.3);
  const std::array<std::string, 2> names{"right arm", "left arm"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SurfaceSegment* arm = Find(fit->model, names[k]);
    ASSERT_NE(arm, nullptr) << names[k];
    EXPECT_LT(AccuracyOf(*arm, scene.columns[k + 1]).rms, 0.5) << names[k];
    EXPECT_NEAR(arm->surface.z_min(), test::kArmLow, scene.pitch);
    EXPECT_NEAR(arm->surface.z_max(), test::kArmHigh, scene.pitch);
  }
  EXPECT_GE(fit->summary.foreground.size(), 2U);
  ExpectAllSamplesAccountedFor(*fit, samples.size());
}

INSTANTIATE_TEST_SUITE_P(Gaps, FitBodyArms, testing::Values(20.0, 60.0, 150.0));

TEST(FitBody, SaysUnknownWhereTheAxisIsBesideTheBody) {
  RingScene scene;
  // A trunk, a neck that bends forward beside the axis, a head around it again.
  scene.columns = {{0.0, 0.0, 170.0, 120.0, 0.0, 402.0},
                   {0.0, 95.0, 60.0, 60.0, 402.0, 552.0},
                   {0.0, 40.0, 80.0, 100.0, 552.0, 800.0}};
  scene.z_max = 800.0;
  scene = Noisy(scene);
  const auto fit = FitBody(scene.Scan(), {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  const SurfaceSegment& body = fit->model.main();
  for (double theta = 0.0; theta < 6.2; theta += 0.1) {
    EXPECT_NE(body.knowledge.At(theta, 300.0), Knowledge::kUnknown);
    EXPECT_NE(body.knowledge.At(theta, 700.0), Knowledge::kUnknown);
    for (double z = 410.0; z < 545.0; z += 15.0) EXPECT_EQ(body.knowledge.At(theta, z), Knowledge::kUnknown) << z;
  }
  const SectionRegion* beside = Region(fit->summary, "beside the axis");
  ASSERT_NE(beside, nullptr);
  EXPECT_NEAR(beside->z_min, 402.0, scene.pitch);
  EXPECT_NEAR(beside->z_max, 552.0, scene.pitch);
  const SurfaceSegment* neck = Find(fit->model, "part beside the axis");
  ASSERT_NE(neck, nullptr) << beside->outcome;
  EXPECT_LT(AccuracyOf(*neck, scene.columns[1]).rms, 0.5);
}

TEST(FitBody, NamesTheHandThatItDoesNotFit) {
  RingScene scene = test::TrunkWithArms(200.0);
  scene.columns.resize(1);
  scene.columns.push_back({390.0, 0.0, 40.0, 45.0, 1002.0, 1298.0});
  for (const double y : {-35.0, 0.0, 35.0}) scene.columns.push_back({400.0, y, 9.0, 9.0, 922.0, 1002.0});
  const auto samples = Noisy(scene).Scan();
  const auto fit = FitBody(samples, {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  const SectionRegion* hand = Region(fit->summary, "right hand");
  ASSERT_NE(hand, nullptr);
  EXPECT_NE(hand->outcome.find("not fitted"), std::string::npos) << hand->outcome;
  EXPECT_EQ(hand->left_out, hand->samples);
  EXPECT_LT(AccuracyOf(fit->model.main(), scene.columns[0]).rms, 0.3);  // no spikes
  ExpectAllSamplesAccountedFor(*fit, samples.size());
}

TEST(FitBody, FailsWhenTheSectionIsNowhereOneLoop) {
  RingScene scene = test::TrunkOnLegs();
  scene.z_max = 700.0;  // legs only
  const auto fit = FitBody(scene.Scan(), {}, {});
  ASSERT_FALSE(fit.has_value());
  EXPECT_NE(fit.error().Text().find("one loop around the ring's axis"), std::string::npos) << fit.error().Text();
}

TEST(FitBody, ReportsProgressThatNeverFallsBackAndEndsComplete) {
  double last = 0.0;
  TaskContext context;
  context.progress = [&](std::string_view, double done, double total) {
    EXPECT_GE(done / total, last);
    last = done / total;
  };
  ASSERT_TRUE(FitBody(test::TrunkOnLegs().Scan(), {}, context).has_value());
  EXPECT_EQ(last, 1.0);
}

TEST(FitBody, GivesTheSameBytesTwice) {
  const auto samples = Noisy(test::TrunkOnLegs()).Scan();
  const auto first = FitBody(samples, {}, {});
  const auto second = FitBody(samples, {}, {});
  ASSERT_TRUE(first.has_value() && second.has_value());
  ASSERT_EQ(first->model.segments.size(), second->model.segments.size());
  for (std::size_t k = 0; k < first->model.segments.size(); ++k) {
    EXPECT_TRUE(first->model.segments[k].surface.coefficients() == second->model.segments[k].surface.coefficients());
    EXPECT_TRUE(first->model.segments[k].axis.at == second->model.segments[k].axis.at);
  }
}

}  // namespace
}  // namespace annulus
