// What the quality monitor says of simulated people, and what a fit makes of it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "acquisition/scan_quality.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/measure/systematic.h"
#include "station/fit_scan.h"
#include "station/quality_picture.h"
#include "station/sim_subject.h"
#include "tests/sim/simulated_scan.h"

namespace annulus {
namespace {

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr; }

ScanPlan PlanOf(const std::string& profile) { return *BuiltInPlan(profile, Millimetres(1700.0)); }

std::unique_ptr<sim::Subject> SubjectOf(const SimConfig& config) {
  PosixStorage storage;
  auto subject = MakeSimSubject(config, storage);
  EXPECT_TRUE(subject) << subject.error().Text();
  return std::move(*subject);
}

SimConfig ConfigOf(const std::string& profile) {
  SimConfig config;
  config.subject = profile == "head" ? "head" : "body";
  return config;
}

/// Seeds of one condition: the subject is cast once without noise, then seen with other noise each time.
std::vector<Scan> ScansOf(const SimConfig& config, const std::string& profile, std::uint64_t seeds) {
  sim::BeamOptions exact;
  exact.noise_sigma_mm = exact.dropout_rate = exact.outlier_rate = 0.0;
  const Scan scan = sim::SimulateScan(*SubjectOf(config), PlanOf(profile), exact, 1);
  std::vector<Scan> scans;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) scans.push_back(sim::NoisyCopy(scan, {}, seed));
  return scans;
}

bool Tells(const ScanQuality& quality, NoticeCode code) {
  return std::any_of(quality.notices.begin(), quality.notices.end(), [&](const auto& n) { return n.code == code; });
}

struct Condition {
  const char* name;
  const char* profile;
  NoticeCode code;
  std::function<void(SimConfig&)> set;
};

void PrintTo(const Condition& condition, std::ostream* out) { *out << condition.name; }

class Notices : public testing::TestWithParam<Condition> {};

TEST_P(Notices, ConditionIsToldInNineteenOfTwentyScansAndNothingElseIs) {
  const Condition& condition = GetParam();
  SimConfig config = ConfigOf(condition.profile);
  condition.set(config);
  const std::uint64_t seeds = IsLong() ? 60 : 5;
  std::size_t told = 0;
  std::size_t more = 0;
  for (const Scan& scan : ScansOf(config, condition.profile, seeds)) {
    const ScanQuality quality = AssessScan(scan);
    told += Tells(quality, condition.code) ? 1 : 0;
    more += std::any_of(quality.notices.begin(), quality.notices.end(),
                        [&](const auto& n) { return n.code != condition.code; })
                ? 1
                : 0;
    for (const QualityNotice& notice : quality.notices) {
      EXPECT_FALSE(notice.text.empty() || notice.advice.empty());
    }
    EXPECT_NE(quality.verdict, QualityVerdict::kGood);
  }
  std::printf("%s: told %zu of %zu, something else %zu\n", condition.name, told, static_cast<std::size_t>(seeds), more);
  EXPECT_GE(20 * told, 19 * seeds);
  EXPECT_LE(20 * more, seeds);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Notices,
    testing::Values(
        Condition{"spectacles", "head", NoticeCode::kSpectacles, [](SimConfig& c) { c.spectacles = true; }},
        Condition{"hair", "head", NoticeCode::kHair, [](SimConfig& c) { c.hair = true; }},
        Condition{"cap", "head", NoticeCode::kCap, [](SimConfig& c) { c.cap = true; }},
        Condition{"dark_patches", "head", NoticeCode::kWeakReturns, [](SimConfig& c) { c.dark_patches = true; }},
        Condition{"left_a_head_scan", "head", NoticeCode::kLeft, [](SimConfig& c) { c.leave_s = 3.0; }},
        Condition{"hair_of_a_body", "body", NoticeCode::kHair, [](SimConfig& c) { c.hair = true; }},
        Condition{"loose_clothing", "body", NoticeCode::kLooseClothing, [](SimConfig& c) { c.loose_clothing = true; }},
        Condition{"stepped_aside", "body", NoticeCode::kMoved, [](SimConfig& c) { c.step_aside_s = 8.0; }},
        Condition{"left", "body", NoticeCode::kLeft, [](SimConfig& c) { c.leave_s = 9.0; }},
        Condition{"arm_raised", "body", NoticeCode::kPartMoved, [](SimConfig& c) { c.raise_arm_s = 9.0; }}),
    [](const testing::TestParamInfo<Condition>& of) { return std::string(of.param.name); });

TEST(ScanNotices, OfACleanBodyThereAreNone) {
  for (const Scan& scan : ScansOf(ConfigOf("body"), "body", IsLong() ? 60 : 20)) {
    const ScanQuality quality = AssessScan(scan);
    EXPECT_EQ(quality.verdict, QualityVerdict::kGood) << TextFromQuality(quality);
    EXPECT_TRUE(quality.notices.empty());
    EXPECT_TRUE(QualityWeights(scan).empty());
  }
}

TEST(ScanNotices, OfAPersonWhoSwaysAndBreathesSayThatAndNoMore) {
  const std::uint64_t seeds = IsLong() ? 40 : 3;
  std::size_t others = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SimConfig config = ConfigOf("body");
    config.sway = 1.0;
    config.breathing = 0.015;
    config.seed = seed;
    const ScanQuality quality = AssessScan(sim::SimulateScan(*SubjectOf(config), PlanOf("body"), {}, seed));
    ASSERT_TRUE(quality.motion);
    EXPECT_GT(std::hypot(quality.motion->sigma_x_mm, quality.motion->sigma_y_mm), 0.3);
    for (const QualityNotice& notice : quality.notices) {
      // One person in twenty sways by twice the median, and may have to be told to stand still.
      others += notice.code != NoticeCode::kSwayed && notice.code != NoticeCode::kMoved ? 1 : 0;
    }
  }
  EXPECT_EQ(others, 0U);
}

TEST(ScanNotices, ThePictureShowsAGapWhereItIs) {
  Scan scan = ScansOf(ConfigOf("head"), "head", 1).front();
  for (ScanLevel& level : scan.levels) {
    const double z = level.readings[0].z_mm;
    for (std::size_t sensor = 130; sensor < 140 && z > 1500.0 && z < 1540.0; ++sensor) {
      level.readings[sensor].range_mm = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const ScanQuality quality = AssessScan(scan);
  ASSERT_EQ(quality.gaps.size(), 1U);
  EXPECT_NE(RegionText(quality.gaps[0]).find("back"), std::string::npos);
  const auto picture = DrawQuality(quality);
  ASSERT_TRUE(picture) << picture.error().Text();
  EXPECT_FALSE(DrawQuality(ScanQuality{}));
}

/// The difference of the radii at two heights in one direction: a lean of the person changes it, noise hardly does.
Estimate RadiusStep(const MeasuredSurface& body, double theta, double z_a, double z_b) {
  const auto radius = [&](double z) {
    GradientSum sum(body.surface());
    sum.AddRadius(theta, z, 1.0);
    return Estimate{body.surface().Radius(theta, z), sum.Get(), 0.0};
  };
  return Combine(1.0, radius(z_a), -1.0, radius(z_b));
}

struct Cover {
  std::size_t all = 0, with = 0, without = 0;
  double sigma_with = 0.0, sigma_without = 0.0;
};

void CountCover(const SurfaceModel& model, const sim::Subject& still, Cover& cover) {
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body) << body.error().Text();
  const auto truth = [&](double theta, double z) {
    const Ray ray{PointFromCylindrical(theta, 600.0, z), -PointFromCylindrical(theta, 1.0, 0.0)};
    return 600.0 - still.Cast(ray, 0.0, 600.0)->distance_mm;
  };
  for (const double theta_deg : {60.0, 90.0, 120.0, 240.0, 270.0, 300.0}) {
    for (const double z : {920.0, 1040.0, 1160.0}) {
      const double theta = RadiansFromDegrees(theta_deg);
      const Estimate step = RadiusStep(*body, theta, z + 150.0, z);
      const double error = std::abs(step.value - (truth(theta, z + 150.0) - truth(theta, z)));
      const double noise = body->WithSigma(step).sigma;
      const double sway = model.systematic ? SigmasFrom(*model.systematic, *body, step).sway : 0.0;
      const double whole = std::hypot(noise, sway);
      ++cover.all;
      cover.with += error <= 1.96 * whole ? 1 : 0;
      cover.without += error <= 1.96 * noise ? 1 : 0;
      cover.sigma_with += whole;
      cover.sigma_without += noise;
    }
  }
}

TEST(ScanNotices, ASwayThatWasSeenWidensIntervalsAndTheyCoverMore) {
  Cover cover;
  const std::uint64_t people = IsLong() ? 30 : 3;
  for (std::uint64_t seed = 1; seed <= people; ++seed) {
    SimConfig config = ConfigOf("body");
    const auto still = SubjectOf(config);
    config.sway = 1.5;
    config.seed = 100 + seed;
    const Scan scan = sim::SimulateScan(*SubjectOf(config), PlanOf("torso"), {}, seed);
    const auto fit = FitScans({scan}, FitOptions{}, {});
    ASSERT_TRUE(fit) << fit.error().Text();
    ASSERT_TRUE(fit->fit.model.systematic && fit->fit.model.systematic->sway);
    CountCover(fit->fit.model, *still, cover);
  }
  std::printf("radius steps: %zu, covered %zu with the sway, %zu without; mean sigma %.2f and %.2f mm\n", cover.all,
              cover.with, cover.without, cover.sigma_with / static_cast<double>(cover.all),
              cover.sigma_without / static_cast<double>(cover.all));
  EXPECT_GT(cover.with, cover.without);
  EXPECT_GT(cover.sigma_with, 1.3 * cover.sigma_without);
}

TEST(ScanNotices, AStillPersonHasNoSwayInTheModel) {
  const Scan scan = ScansOf(ConfigOf("body"), "torso", 1).front();
  const auto fit = FitScans({scan}, FitOptions{}, {});
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_FALSE(fit->fit.model.systematic && fit->fit.model.systematic->sway);
}

}  // namespace
}  // namespace annulus
