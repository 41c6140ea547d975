#include "fitting/fit_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>

#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::Normal;
using test::ScanShape;
using test::SmoothTrunk;
using test::SyntheticScan;
using test::Uniform;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Result<FitResult> Fit(const std::vector<SurfaceSample>& samples, FitMethod method = FitMethod::kAdaptive) {
  FitOptions options;
  options.method = method;
  return FitSurface(samples, options, {});
}

const SplineSurface& SurfaceOf(const Result<FitResult>& fit) { return fit->model.main().surface; }

/// RMS and largest distance of a fitted surface from the truth, mm, over a grid that is not the samples'.
struct Errors {
  double rms = 0.0;
  double largest = 0.0;
};
Errors ErrorsOf(const SplineSurface& surface, const test::RadiusFunction& truth, double z_low, double z_high) {
  Errors errors;
  double squares = 0.0;
  std::size_t count = 0;
  for (double z = z_low; z <= z_high; z += 3.7) {
    for (double theta = 0.01; theta < kTwoPi; theta += 0.043) {
      const double error = surface.Radius(theta, z) - truth(theta, z);
      squares += error * error;
      errors.largest = std::max(errors.largest, std::abs(error));
      ++count;
    }
  }
  errors.rms = std::sqrt(squares / static_cast<double>(count));
  return errors;
}

std::size_t Rejected(const FitSummary& summary, SampleVerdict reason) {
  return static_cast<std::size_t>(std::count_if(summary.rejected.begin(), summary.rejected.end(),
                                                [&](const RejectedSample& r) { return r.reason == reason; }));
}

/// What is true of every fit that succeeded.
void ExpectSound(const FitResult& fit) {
  const SplineSurface& surface = fit.model.main().surface;
  EXPECT_TRUE(surface.coefficients().allFinite());
  for (int k = 0; k <= 10; ++k) {
    const double z = surface.z_min() + (surface.z_max() - surface.z_min()) * k / 10.0;
    const RadiusJet start = surface.Jet(0.0, z);
    const RadiusJet end = surface.Jet(std::nextafter(kTwoPi, 0.0), z);
    const double scale = 1e-9 * (1.0 + std::abs(start.r) + std::abs(start.r_theta));
    EXPECT_EQ(surface.Radius(kTwoPi, z), start.r);
    EXPECT_NEAR(end.r, start.r, scale);
    EXPECT_NEAR(end.r_theta, start.r_theta, scale);
  }
  EXPECT_EQ(fit.summary.used + fit.summary.rejected.size(), fit.summary.samples);
  EXPECT_TRUE(std::isfinite(fit.summary.noise_sigma_mm));
  EXPECT_TRUE(std::isfinite(fit.summary.rms_mm));
  EXPECT_GT(fit.model.main().normal_matrix.nonZeros(), 0);
  for (Eigen::Index k = 0; k < fit.model.main().normal_matrix.nonZeros(); ++k) {
    ASSERT_TRUE(std::isfinite(fit.model.main().normal_matrix.valuePtr()[k]));
  }
}

TEST(FitSurface, RecoversASmoothSurfaceWithoutNoise) {
  const ScanShape shape;
  const auto fit = Fit(SyntheticScan(SmoothTrunk, shape));
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_TRUE(fit->summary.rejected.empty());
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).rms, 5e-3);
}

TEST(FitSurface, RecoversACylinderExactly) {
  const ScanShape shape;
  const auto cylinder = [](double, double) { return 123.456; };
  const auto fit = Fit(SyntheticScan(cylinder, shape));
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), cylinder, 0.0, shape.z_max()).largest, 1e-3);
}

class FitSurfaceMethods : public testing::TestWithParam<FitMethod> {};

TEST_P(FitSurfaceMethods, SmoothHalfAMillimetreOfNoiseAndTellItsSize) {
  ScanShape shape;
  shape.noise = 0.5;
  double chi_square = 0.0;
  constexpr int kSeeds = 2;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    shape.seed = seed;
    const auto fit = Fit(SyntheticScan(SmoothTrunk, shape), GetParam());
    ASSERT_TRUE(fit.has_value()) << fit.error().Text();
    ExpectSound(*fit);
    EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).rms, 0.2) << "seed " << seed;
    EXPECT_GE(fit->summary.noise_sigma_mm, 0.9 * 0.5) << "seed " << seed;
    EXPECT_LE(fit->summary.noise_sigma_mm, 1.1 * 0.5) << "seed " << seed;
    chi_square += std::pow(fit->summary.noise_sigma_mm / 0.5, 2) / kSeeds;
  }
  EXPECT_NEAR(chi_square, 1.0, 0.12);
}

INSTANTIATE_TEST_SUITE_P(Both, FitSurfaceMethods, testing::Values(FitMethod::kAdaptive, FitMethod::kUniform));

TEST(FitSurface, IsNotMovedByOutliers) {
  ScanShape shape;
  shape.noise = 0.5;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::mt19937_64 random(11);
  std::set<std::size_t> bad;
  while (bad.size() < samples.size() / 20) bad.insert(random() % samples.size());
  for (const std::size_t k : bad) samples[k].radius += Uniform(random, -200.0, 200.0);
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).rms, 0.25);
  EXPECT_NEAR(fit->summary.noise_sigma_mm, 0.5, 0.1);
  std::size_t wrongly = 0;
  for (const RejectedSample& r : fit->summary.rejected) wrongly += bad.contains(r.index) ? 0 : 1;
  EXPECT_LE(wrongly, samples.size() / 500);
}

TEST(FitSurface, BridgesADeadSensor) {
  ScanShape shape;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor == 17; });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).rms, 0.15);
  EXPECT_NE(fit->model.main().knowledge.At(kTwoPi * 17 / 90.0, 100.0), Knowledge::kUnknown);
}

TEST(FitSurface, SaysWhatADeadBoardDidNotSee) {
  // 15 of 180 sensors: the returns beside the gap are at 58 and 90 degrees. At z = 100 the radius in the middle is
  // 150 + 12 cos 148° + 5 sin(222° + 1 rad) + 10 sin 120° = 143.6 mm: 16 degrees are 40.1 mm, 12 degrees 30 mm.
  ScanShape shape;
  shape.sensors = 180;
  shape.levels = 40;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor >= 30 && s.sensor < 45; });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  const KnowledgeMap& knowledge = fit->model.main().knowledge;
  EXPECT_EQ(knowledge.At(RadiansFromDegrees(70.0), 100.0), Knowledge::kInferred);
  EXPECT_EQ(knowledge.At(RadiansFromDegrees(74.0), 100.0), Knowledge::kUnknown);
  EXPECT_EQ(knowledge.At(RadiansFromDegrees(200.0), 100.0), Knowledge::kMeasured);
  // It bridges without running off: the gap is a smooth 30 degrees.
  for (double theta = RadiansFromDegrees(60.0); theta < RadiansFromDegrees(90.0); theta += 0.01) {
    EXPECT_NEAR(SurfaceOf(fit).Radius(theta, 100.0), SmoothTrunk(theta, 100.0), 8.0) << theta;
  }
}

TEST(FitSurface, FindsAnOutlierOnSteepGround) {
  // 15 mm from level to level: 20 mm off is within what the 24 neighbours span, so only the surface gives it away.
  ScanShape shape;
  shape.noise = 0.3;
  std::vector<SurfaceSample> samples = SyntheticScan([](double, double z) { return 60.0 + 3.0 * z; }, shape);
  const std::size_t wild = 30U * shape.sensors + 17U;
  samples[wild].radius -= 20.0;
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ASSERT_EQ(fit->summary.rejected.size(), 1U);
  EXPECT_EQ(fit->summary.rejected[0].index, wild);
  EXPECT_EQ(fit->summary.rejected[0].reason, SampleVerdict::kOutlier);
  EXPECT_EQ(fit->summary.used, samples.size() - 1);
}

TEST(FitSurface, BridgesTenMissingLevels) {
  ScanShape shape;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.level >= 25 && s.level < 35; });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, 118.0).rms, 0.15);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 177.0, shape.z_max()).rms, 0.15);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 120.0, 175.0).largest, 8.0);
  EXPECT_EQ(fit->model.main().knowledge.At(1.0, 147.0), Knowledge::kInferred);
}

TEST(FitSurface, KnowsNothingInTheMiddleOfAWideHole) {
  // A quarter turn is missing over all heights: 235 mm of skin, its middle 118 mm from any return.
  ScanShape shape;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.theta > 1.0 && s.theta < 1.0 + kPi / 2.0; });
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  const KnowledgeMap& knowledge = fit->model.main().knowledge;
  EXPECT_EQ(knowledge.At(1.0 + kPi / 4.0, 150.0), Knowledge::kUnknown);
  EXPECT_EQ(knowledge.At(1.0 + 27.0 / 150.0, 150.0), Knowledge::kInferred);
  EXPECT_EQ(knowledge.At(4.0, 150.0), Knowledge::kMeasured);
  EXPECT_EQ(knowledge.At(4.0, shape.z_max() + 50.0), Knowledge::kUnknown);
}

TEST(FitSurface, LeavesAnArmBeforeTheTrunkOutAndReportsIt) {
  // An upright arm of radius 25 mm, 100 mm off the skin at theta 0, from z = 50 to 250, seen before the trunk.
  const ScanShape shape;
  const auto with_arm = [](double theta, double z) {
    const double distance = 260.0;  // of the arm's axis from the ring's
    const double across = distance * std::sin(theta);
    if (z < 50.0 || z > 250.0 || std::cos(theta) < 0.0 || std::abs(across) > 25.0) return SmoothTrunk(theta, z);
    return distance * std::cos(theta) + std::sqrt(25.0 * 25.0 - across * across);
  };
  const auto fit = Fit(SyntheticScan(with_arm, shape));
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  ASSERT_EQ(fit->summary.foreground.size(), 1U);
  const ForegroundObject& arm = fit->summary.foreground.front();
  EXPECT_NEAR(arm.z_min, 50.0, 6.0);
  EXPECT_NEAR(arm.z_max, 250.0, 6.0);
  EXPECT_NEAR(AngleDifference(arm.theta, 0.0), 0.0, 0.1);
  EXPECT_EQ(arm.samples, Rejected(fit->summary, SampleVerdict::kForeground));
  EXPECT_GT(arm.samples, 90U);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).largest, 4.0);
}

TEST(FitSurface, TakesSamplesInAnyOrder) {
  ScanShape shape;
  shape.noise = 0.3;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  const auto fit = Fit(samples);
  std::reverse(samples.begin(), samples.end());
  const auto reversed = Fit(samples);
  ASSERT_TRUE(fit.has_value() && reversed.has_value());
  EXPECT_LE(
      ErrorsOf(
          SurfaceOf(reversed), [&](double t, double z) { return SurfaceOf(fit).Radius(t, z); }, 0.0, shape.z_max())
          .largest,
      1e-3);
}

TEST(FitSurface, TurnsWithTheScan) {
  // The same scan with all sensors renumbered by 20 places gives the same surface, turned.
  ScanShape shape;
  shape.noise = 0.3;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  const auto fit = Fit(samples);
  const double turn = kTwoPi * 20.0 / 90.0;
  for (SurfaceSample& s : samples) {
    s.theta = WrapAngle(s.theta + turn);
    s.sensor = static_cast<std::uint16_t>((s.sensor + 20) % 90);
  }
  const auto turned = Fit(samples);
  ASSERT_TRUE(fit.has_value() && turned.has_value());
  const auto expected = [&](double t, double z) { return SurfaceOf(fit).Radius(t - turn, z); };
  // Knots stay where they are, so the two differ a little where detail is finer than they are.
  EXPECT_LE(ErrorsOf(SurfaceOf(turned), expected, 0.0, shape.z_max()).rms, 0.05);
}

TEST(FitSurface, GivesTheSameBytesTwice) {
  ScanShape shape;
  shape.noise = 0.5;
  const std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  const auto first = Fit(samples);
  const auto second = Fit(samples);
  ASSERT_TRUE(first.has_value() && second.has_value());
  const Eigen::VectorXd& a = SurfaceOf(first).coefficients();
  const Eigen::VectorXd& b = SurfaceOf(second).coefficients();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())), 0);
  EXPECT_EQ((first->model.main().normal_matrix - second->model.main().normal_matrix).norm(), 0.0);
}

TEST(FitSurface, ReportsProgressThatNeverFallsBackAndEndsComplete) {
  TaskContext context;
  double last = 0.0;
  context.progress = [&](std::string_view stage, double done, double total) {
    EXPECT_FALSE(stage.empty());
    EXPECT_GE(done / total, last);
    EXPECT_LE(done, total);
    last = done / total;
  };
  ASSERT_TRUE(FitSurface(SyntheticScan(SmoothTrunk, {}), {}, context).has_value());
  EXPECT_EQ(last, 1.0);
}

TEST(FitSurfaceBadInput, FailsWithTooFewLevelsReturnsOrSensors) {
  ScanShape shape;
  shape.levels = 7;
  const auto few_levels = Fit(SyntheticScan(SmoothTrunk, shape));
  ASSERT_FALSE(few_levels.has_value());
  EXPECT_THAT(few_levels.error().Text(), testing::HasSubstr("levels"));
  shape = {};
  shape.sensors = 4;
  EXPECT_FALSE(Fit(SyntheticScan(SmoothTrunk, shape)).has_value());
  EXPECT_FALSE(Fit({}).has_value());
  EXPECT_FALSE(Fit({SurfaceSample{}}).has_value());
}

TEST(FitSurfaceBadInput, FailsWhenAllLevelsLieAtOneHeight) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  for (SurfaceSample& s : samples) s.z = 100.0;
  const auto fit = Fit(samples);
  ASSERT_FALSE(fit.has_value());
  EXPECT_FALSE(fit.error().seen.empty());
}

TEST(FitSurfaceBadInput, FailsWhenAllSamplesLieInOneDirection) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  for (SurfaceSample& s : samples) s.theta = 1.0;
  const auto fit = Fit(samples);
  if (fit) ExpectSound(*fit);
}

TEST(FitSurfaceBadInput, TakesEqualRangesEverywhere) {
  std::vector<SurfaceSample> samples = SyntheticScan([](double, double) { return 100.0; }, {});
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_NEAR(SurfaceOf(fit).Radius(1.0, 50.0), 100.0, 1e-6);
}

/// Spoils one of 50 samples by `spoil`; the rest must be fitted as if those were not there.
void ExpectUnspoiled(const std::function<void(SurfaceSample&)>& spoil) {
  ScanShape shape;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  for (std::size_t k = 7; k < samples.size(); k += 50) spoil(samples[k]);
  const auto fit = Fit(samples);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  ExpectSound(*fit);
  EXPECT_NEAR(SurfaceOf(fit).z_min(), 0.0, 1e-9);
  EXPECT_NEAR(SurfaceOf(fit).z_max(), shape.z_max(), 1e-9);
  EXPECT_LE(ErrorsOf(SurfaceOf(fit), SmoothTrunk, 0.0, shape.z_max()).rms, 0.2);
}

TEST(FitSurfaceBadInput, LeavesSamplesOutThatAreNotFinite) {
  ExpectUnspoiled([](SurfaceSample& s) { s.radius = kNan; });
  ExpectUnspoiled([](SurfaceSample& s) { s.radius = std::numeric_limits<double>::infinity(); });
  ExpectUnspoiled([](SurfaceSample& s) { s.theta = kNan; });
  ExpectUnspoiled([](SurfaceSample& s) { s.z = kNan; });
  ExpectUnspoiled([](SurfaceSample& s) { s.z = -std::numeric_limits<double>::infinity(); });
}

TEST(FitSurfaceBadInput, LeavesImpossibleRadiiOut) {
  ExpectUnspoiled([](SurfaceSample& s) { s.radius = 1e308; });
  ExpectUnspoiled([](SurfaceSample& s) { s.radius = -50.0; });
  ExpectUnspoiled([](SurfaceSample& s) { s.radius = 0.0; });
}

TEST(FitSurfaceBadInput, LeavesImpossibleHeightsOut) {
  // A height that is 1e308 mm away from its level's others must not stretch the surface to it.
  ExpectUnspoiled([](SurfaceSample& s) { s.z = 1e308; });
  ExpectUnspoiled([](SurfaceSample& s) { s.z = -1e6; });
}

TEST(FitSurfaceBadInput, LeavesSamplesOutWhoseWeightMakesNoSense) {
  ExpectUnspoiled([](SurfaceSample& s) { s.weight = std::numeric_limits<float>::quiet_NaN(); });
  ExpectUnspoiled([](SurfaceSample& s) { s.weight = -1.0F; });
  ExpectUnspoiled([](SurfaceSample& s) { s.weight = std::numeric_limits<float>::infinity(); });
  ExpectUnspoiled([](SurfaceSample& s) { s.weight = 0.0F; });
}

TEST(FitSurfaceBadInput, FailsWhenNothingIsFinite) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  for (SurfaceSample& s : samples) s.radius = kNan;
  EXPECT_FALSE(Fit(samples).has_value());
  for (SurfaceSample& s : samples) s.z = kNan;
  EXPECT_FALSE(Fit(samples).has_value());
  for (SurfaceSample& s : samples) s.theta = kNan;
  EXPECT_FALSE(Fit(samples).has_value());
}

TEST(FitSurfaceBadInput, FitsOrRefusesMostlyBrokenScansWithoutCrashing) {
  const double specials[] = {kNan, 1e308, -1e308, std::numeric_limits<double>::infinity(), 0.0, 5e-324, 1e-3};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    ScanShape shape;
    shape.levels = 20;
    shape.sensors = 24;
    std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
    std::mt19937_64 random(seed);
    for (SurfaceSample& s : samples) {
      const double special = specials[random() % std::size(specials)];
      switch (random() % 8) {
        case 0:
          s.radius = special;
          break;
        case 1:
          s.z = special;
          break;
        case 2:
          s.theta = special;
          break;
        case 3:
          s.level = static_cast<std::uint32_t>(random() % 20);
          break;
        default:
          break;
      }
    }
    const auto fit = Fit(samples);
    if (fit) {
      ExpectSound(*fit);
    } else {
      EXPECT_EQ(fit.error().Text().find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace annulus
