#include "fitting/paper_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

Result<FitResult> Fit(const std::vector<SurfaceSample>& samples) {
  FitOptions options;
  options.method = FitMethod::kPaper;
  return FitSurface(samples, options, TaskContext());
}

const PaperModel& PaperOf(const FitResult& fit) { return *fit.model.main().paper; }

test::ScanShape Shape() { return {.levels = 61, .sensors = 180, .pitch = 5.0, .noise = 0.5, .seed = 1}; }

double RmsToTruth(const PaperSurface& surface, const test::RadiusFunction& truth) {
  double squares = 0.0;
  std::size_t count = 0;
  for (double z = surface.z_min(); z <= surface.z_max(); z += 3.0) {
    for (double theta = 0.0; theta < kTwoPi; theta += 0.05) {
      squares += std::pow(surface.Radius(theta, z) - truth(theta, z), 2);
      ++count;
    }
  }
  return std::sqrt(squares / static_cast<double>(count));
}

TEST(FitPaper, FollowsASmoothTrunkBelowItsNoise) {
  const auto fit = Fit(test::SyntheticScan(test::SmoothTrunk, Shape()));
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(RmsToTruth(PaperOf(*fit).surface, test::SmoothTrunk), 0.25);  // of a noise of 0.5
  EXPECT_NEAR(fit->summary.noise_sigma_mm, 0.5, 0.05);
  EXPECT_EQ(fit->model.provenance.method, "paper");
  EXPECT_EQ(fit->model.main().normal_matrix.nonZeros(), 0);
  EXPECT_EQ(fit->model.main().knowledge.At(1.0, 150.0), Knowledge::kMeasured);
}

TEST(FitPaper, PutsItsKnotLinesWhereItsReportSays) {
  const auto fit = Fit(test::SyntheticScan(test::SmoothTrunk, Shape()));
  ASSERT_TRUE(fit.has_value());
  const PaperModel& paper = PaperOf(*fit);
  const PaperSurface& surface = paper.surface;
  EXPECT_EQ(surface.theta_knots(), paper.report.around.plan.knots);
  EXPECT_EQ(surface.z_knots(), paper.report.along.plan.knots);
  EXPECT_EQ(surface.theta_knots().size(), 3 * paper.report.around.plan.features.size());
  EXPECT_EQ(surface.z_knots().size(), 3 * paper.report.along.plan.features.size() - 2);
  for (std::size_t j = 0; j < surface.z_knots().size(); ++j) {
    for (std::size_t i = 0; i < surface.theta_knots().size(); ++i) {
      const Eigen::Vector3d p = surface.PointAt({static_cast<double>(i), static_cast<double>(j)});
      const double r = p.head<2>().norm();
      EXPECT_LE((p - PointFromCylindrical(surface.theta_knots()[i], r, surface.z_knots()[j])).norm(), 1e-9);
    }
  }
}

TEST(FitPaper, ChoosesTheSectionWithMostFeatures) {
  // Above z = 200 six waves around, below it two.
  const auto body = [](double theta, double z) {
    const double share = 1.0 / (1.0 + std::exp(-(z - 200.0) / 10.0));
    return 150.0 + (1.0 - share) * 12.0 * std::cos(2.0 * theta) + share * 8.0 * std::cos(6.0 * theta);
  };
  const auto fit = Fit(test::SyntheticScan(body, Shape()));
  ASSERT_TRUE(fit.has_value());
  const PaperDirection& around = PaperOf(*fit).report.around;
  EXPECT_GT(around.place, 190.0);
  EXPECT_EQ(around.complexity.features, 24U);  // 12 extrema and 12 inflections
}

TEST(FitPaper, StatesItsLambdaAndLowersEquation24) {
  const auto fit = Fit(test::SyntheticScan(test::SmoothTrunk, Shape()));
  ASSERT_TRUE(fit.has_value());
  for (const PaperDirection& direction : {PaperOf(*fit).report.around, PaperOf(*fit).report.along}) {
    EXPECT_GT(direction.lambda, 0.0);
    EXPECT_LE(direction.cost_moved, direction.cost_by_rule);
    EXPECT_GT(direction.effective, 2.0);
  }
}

TEST(FitPaper, FitsACylinderWithoutAnyFeature) {
  auto shape = Shape();
  shape.noise = 0.0;
  const auto fit = Fit(test::SyntheticScan([](double, double) { return 120.0; }, shape));
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(RmsToTruth(PaperOf(*fit).surface, [](double, double) { return 120.0; }), 0.01);
}

TEST(FitPaper, BridgesADeadBoardAndMissingLevels) {
  std::vector<SurfaceSample> samples = test::SyntheticScan(test::SmoothTrunk, Shape());
  std::erase_if(samples, [](const SurfaceSample& s) {
    return (s.sensor >= 40 && s.sensor < 55) || (s.level >= 25 && s.level < 35) || s.sensor == 120;
  });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(RmsToTruth(PaperOf(*fit).surface, test::SmoothTrunk), 2.0);
}

TEST(FitPaper, LeavesOutLevelsThatWereNotSeenAllAround) {
  std::vector<SurfaceSample> samples = test::SyntheticScan(test::SmoothTrunk, Shape());
  std::erase_if(samples, [](const SurfaceSample& s) { return s.level < 20 && s.sensor < 60; });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(PaperOf(*fit).surface.z_min(), 100.0, 1e-9);
  EXPECT_EQ(PaperOf(*fit).report.levels_outside, 20U);
  EXPECT_EQ(fit->model.main().knowledge.At(5.0, 50.0), Knowledge::kUnknown);
}

TEST(FitPaper, GivesTheSameSurfaceTwice) {
  const std::vector<SurfaceSample> samples = test::SyntheticScan(test::SmoothTrunk, Shape());
  const auto first = Fit(samples);
  const auto second = Fit(samples);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(PaperOf(*first).surface.control(), PaperOf(*second).surface.control());
}

TEST(FitPaper, MergesSweepsAtTheSameHeights) {
  std::vector<SurfaceSample> samples;
  for (std::uint16_t sweep = 0; sweep < 3; ++sweep) {
    auto shape = Shape();
    shape.seed = sweep + 1U;
    for (SurfaceSample sample : test::SyntheticScan(test::SmoothTrunk, shape)) {
      sample.sweep = sweep;
      sample.z += 0.1 * sweep;
      samples.push_back(sample);
    }
  }
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(PaperOf(*fit).report.levels, 61U);
  EXPECT_LT(RmsToTruth(PaperOf(*fit).surface, test::SmoothTrunk), 0.25);
}

/// What a broken ring may deliver.
struct Damage {
  const char* name;
  std::function<void(std::vector<SurfaceSample>&)> apply;
};

class DamagedScan : public testing::TestWithParam<Damage> {};

TEST_P(DamagedScan, GivesAFiniteSurfaceOrAClearError) {
  std::vector<SurfaceSample> samples = test::SyntheticScan(test::SmoothTrunk, Shape());
  GetParam().apply(samples);
  const auto fit = Fit(samples);
  if (!fit) {
    EXPECT_FALSE(fit.error().advice.empty());
    EXPECT_EQ(fit.error().Text().find('\n'), std::string::npos);
    return;
  }
  const PaperSurface& surface = PaperOf(*fit).surface;
  for (double z = surface.z_min(); z <= surface.z_max(); z += 2.0) {
    for (double theta = 0.0; theta < kTwoPi; theta += 0.02) {
      const double r = surface.Radius(theta, z);
      ASSERT_TRUE(r > 0.0 && r < 600.0) << r;
    }
  }
  EXPECT_TRUE(std::isfinite(fit->summary.rms_mm));
}

template <class Change>
std::function<void(std::vector<SurfaceSample>&)> EverySample(Change change) {
  return [change](std::vector<SurfaceSample>& samples) {
    std::mt19937_64 random(11);
    for (SurfaceSample& sample : samples) change(sample, random);
  };
}

INSTANTIATE_TEST_SUITE_P(
    All, DamagedScan,
    testing::Values(
        Damage{"Outliers", EverySample([](SurfaceSample& s, std::mt19937_64& random) {
                 if (test::Uniform(random, 0.0, 1.0) < 0.05) s.radius += test::Uniform(random, -200.0, 200.0);
               })},
        Damage{"DeadSensor", [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor == 33; }); }},
        Damage{"DeadBoard", [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor / 15 == 4; }); }},
        Damage{"HalfTheRing", [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor < 90; }); }},
        Damage{"MissingLevels",
               [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.level / 10 == 3; }); }},
        Damage{"AllEqual", EverySample([](SurfaceSample& s, std::mt19937_64&) { s.radius = 100.0; })},
        Damage{"AllZero", EverySample([](SurfaceSample& s, std::mt19937_64&) { s.radius = 0.0; })},
        Damage{"Nan", EverySample([](SurfaceSample& s, std::mt19937_64& random) {
                 if (random() % 7 == 0) s.radius = std::numeric_limits<double>::quiet_NaN();
                 if (random() % 97 == 0) s.z = std::numeric_limits<double>::quiet_NaN();
                 if (random() % 101 == 0) s.theta = std::numeric_limits<double>::infinity();
               })},
        Damage{"Huge", EverySample([](SurfaceSample& s, std::mt19937_64& random) {
                 if (random() % 31 == 0) s.radius = 1e308;
                 if (random() % 53 == 0) s.radius = -1e308;
                 if (random() % 59 == 0) s.z = 1e308;
               })},
        Damage{"PureNoise", EverySample([](SurfaceSample& s, std::mt19937_64& random) {
                 s.radius = test::Uniform(random, 50.0, 300.0);
               })},
        Damage{"OneLevel", [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.level != 7; }); }},
        Damage{"OneSensor", [](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor != 7; }); }},
        Damage{"SameHeight", EverySample([](SurfaceSample& s, std::mt19937_64&) { s.z = 5.0; })},
        Damage{"SameAngle", EverySample([](SurfaceSample& s, std::mt19937_64&) { s.theta = 1.0; })},
        Damage{"Empty", [](auto& samples) { samples.clear(); }},
        Damage{"Step", EverySample([](SurfaceSample& s, std::mt19937_64&) {
                 if (s.theta > 1.0 && s.theta < 2.5) s.radius += 60.0;
               })},
        Damage{"ThinSpike", EverySample([](SurfaceSample& s, std::mt19937_64&) {
                 if (s.sensor >= 20 && s.sensor < 23) s.radius += 25.0;
               })},
        Damage{"NoWeight", EverySample([](SurfaceSample& s, std::mt19937_64&) { s.weight = 0.0F; })}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace annulus
