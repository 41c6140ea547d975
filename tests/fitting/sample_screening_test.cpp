#include "fitting/sample_screening.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "fitting/cell_grid.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::ScanShape;
using test::SmoothTrunk;
using test::SyntheticScan;
using test::Uniform;

std::vector<SampleVerdict> VerdictsOf(const std::vector<SurfaceSample>& samples) {
  return ScreenSamples(samples, SampleGrid(samples), {}).verdicts;
}

/// How many samples the outlier rule alone (nothing is foreground) judges otherwise than `expected`.
std::size_t Differences(const std::vector<SurfaceSample>& samples, const std::vector<SampleVerdict>& expected) {
  ScreeningOptions options;
  options.foreground_step_mm = 1e9;
  const std::vector<SampleVerdict> verdicts = ScreenSamples(samples, SampleGrid(samples), options).verdicts;
  std::size_t differences = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) differences += verdicts[k] != expected[k] ? 1 : 0;
  return differences;
}

CellGrid CellsOf(const std::vector<SurfaceSample>& samples) {
  const SampleGrid grid(samples);
  const Screening screening = ScreenSamples(samples, grid, {});
  return {samples, grid, screening.verdicts};
}

/// A noisy scan in which every 20th sample is moved by up to 200 mm and every 30th is missing.
std::vector<SurfaceSample> SpoiledScan(std::uint64_t seed) {
  ScanShape shape;
  shape.noise = 0.5;
  shape.seed = seed;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::mt19937_64 random(seed);
  std::erase_if(samples, [&](const SurfaceSample&) { return random() % 30 == 0; });
  for (SurfaceSample& s : samples) {
    if (random() % 20 == 0) s.radius += Uniform(random, -200.0, 200.0);
  }
  return samples;
}

/// The outlier rule as it is written down, by sorting whole neighbourhoods: 5 mm beyond all but one of 24, confirmed
/// if 3 mm beyond those of 8 that are not candidates; up to four times.
std::vector<SampleVerdict> VerdictsBySorting(const std::vector<SurfaceSample>& samples) {
  const SampleGrid grid(samples);
  std::vector<SampleVerdict> verdicts;
  for (const SurfaceSample& s : samples) {
    verdicts.push_back(IsUsable(s) ? SampleVerdict::kGood : SampleVerdict::kOutlier);
  }
  const auto around = [&](std::size_t row, std::size_t column, int half, const std::set<std::size_t>& without) {
    std::vector<double> radii;
    for (int dr = -half; dr <= half; ++dr) {
      for (int dc = -half; dc <= half; ++dc) {
        const auto r = static_cast<std::ptrdiff_t>(row) + dr;
        if ((dr == 0 && dc == 0) || r < 0 || r >= static_cast<std::ptrdiff_t>(grid.rows())) continue;
        const std::size_t k = grid.At(static_cast<std::size_t>(r), grid.Column(column, dc));
        if (k == SampleGrid::kNone || verdicts[k] != SampleVerdict::kGood || without.contains(k)) continue;
        radii.push_back(samples[k].radius);
      }
    }
    std::sort(radii.begin(), radii.end());
    return radii;
  };
  const auto beyond = [](const std::vector<double>& radii, std::size_t rank, double radius) {
    return std::max(radius - radii[radii.size() - 1 - rank], radii[rank] - radius);
  };
  for (int pass = 0; pass < 4; ++pass) {
    std::set<std::size_t> candidates;
    std::set<std::size_t> outliers;
    for (const bool confirm : {false, true}) {
      for (std::size_t row = 0; row < grid.rows(); ++row) {
        for (std::size_t column = 0; column < grid.columns(); ++column) {
          const std::size_t k = grid.At(row, column);
          if (k == SampleGrid::kNone || verdicts[k] != SampleVerdict::kGood) continue;
          if (!confirm) {
            const std::vector<double> radii = around(row, column, 2, {});
            if (radii.size() < 4 || beyond(radii, 1, samples[k].radius) > 5.0) candidates.insert(k);
          } else if (candidates.contains(k)) {
            const std::vector<double> radii = around(row, column, 1, candidates);
            if (radii.empty() || beyond(radii, 0, samples[k].radius) > 3.0) outliers.insert(k);
          }
        }
      }
    }
    for (const std::size_t k : outliers) verdicts[k] = SampleVerdict::kOutlier;
    if (outliers.empty()) break;
  }
  return verdicts;
}

TEST(ScreenSamples, FollowsTheRuleToTheSample) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::vector<SurfaceSample> samples = SpoiledScan(seed);
    const std::vector<SampleVerdict> expected = VerdictsBySorting(samples);
    EXPECT_EQ(Differences(samples, expected), 0U) << "seed " << seed;
    EXPECT_GT(std::count(expected.begin(), expected.end(), SampleVerdict::kOutlier), 150) << "seed " << seed;
  }
}

TEST(ScreenSamples, FollowsTheRuleOnRingsOfOneToFiveSensors) {
  for (std::uint16_t sensors = 1; sensors <= 5; ++sensors) {
    std::vector<SurfaceSample> samples = SpoiledScan(7);
    std::erase_if(samples, [&](const SurfaceSample& s) { return s.sensor >= sensors; });
    EXPECT_EQ(Differences(samples, VerdictsBySorting(samples)), 0U) << sensors << " sensors";
  }
}

TEST(ScreenSamples, ScreensTheSecondSampleOfACellToo) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  const SurfaceSample twin = samples[30 * 90 + 40];
  samples.push_back(twin);
  samples.push_back(twin);
  samples.back().radius += 80.0;
  const std::vector<SampleVerdict> verdicts = VerdictsOf(samples);
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) EXPECT_EQ(verdicts[k], SampleVerdict::kGood) << k;
  EXPECT_EQ(verdicts.back(), SampleVerdict::kOutlier);
}

TEST(ScreenSamples, ScreensASecondPassThatCountsItsLevelsFromZeroAgain) {
  // Both passes of one sweep number; the second one is 2.5 mm higher and has one wild return.
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  const std::size_t first = samples.size();
  for (std::size_t k = 0; k < first; ++k) {
    samples.push_back(samples[k]);
    samples.back().z += 2.5;
    samples.back().radius = SmoothTrunk(samples[k].theta, samples[k].z + 2.5);
  }
  samples[first + 1234].radius += 60.0;
  EXPECT_EQ(SampleGrid(samples).rows(), 120U);
  const std::vector<SampleVerdict> verdicts = VerdictsOf(samples);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    EXPECT_EQ(verdicts[k], k == first + 1234 ? SampleVerdict::kOutlier : SampleVerdict::kGood) << k;
  }
}

TEST(ScreenSamples, KeepsNoMoreThanSixteenSamplesOfOneCell) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  const std::vector<SurfaceSample> twins(40, samples[30 * 90 + 40]);
  samples.insert(samples.end(), twins.begin(), twins.end());
  const std::vector<SampleVerdict> verdicts = VerdictsOf(samples);
  EXPECT_EQ(std::count(verdicts.begin(), verdicts.end(), SampleVerdict::kOutlier), 40 - 15);
}

TEST(SampleGrid, IsEmptyWhenSamplesAreTooScatteredForAScan) {
  std::mt19937_64 random(4);
  std::vector<SurfaceSample> samples(20'000);
  for (SurfaceSample& s : samples) {
    s.theta = Uniform(random, 0.0, kTwoPi);
    s.z = Uniform(random, 0.0, 1000.0);
    s.radius = 100.0;
    s.level = static_cast<std::uint32_t>(random());
    s.sensor = static_cast<std::uint16_t>(random());
  }
  EXPECT_EQ(SampleGrid(samples).rows(), 0U);
  const std::vector<SampleVerdict> verdicts = VerdictsOf(samples);
  EXPECT_EQ(std::count(verdicts.begin(), verdicts.end(), SampleVerdict::kOutlier), 20'000);
}

TEST(SampleGrid, IsEmptyWhenMostSamplesShareTheirCells) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  for (SurfaceSample& s : samples) s.level = 3;  // 60 levels that all say they are the fourth
  EXPECT_EQ(SampleGrid(samples).rows(), 0U);
}

TEST(SampleGrid, HoldsNoSampleThatCannotBe) {
  const auto held = [](const std::function<void(SurfaceSample&)>& spoil) {
    std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
    spoil(samples[1000]);
    const SampleGrid grid(samples);
    std::size_t count = 0;
    for (std::size_t row = 0; row < grid.rows(); ++row) {
      for (std::size_t column = 0; column < grid.columns(); ++column) count += grid.At(row, column) == 1000U ? 1 : 0;
    }
    return count == 1;
  };
  EXPECT_TRUE(held([](SurfaceSample& s) { s.weight = 1e-5F; }));
  EXPECT_FALSE(held([](SurfaceSample& s) { s.weight = 1e-30F; }));
  EXPECT_FALSE(held([](SurfaceSample& s) { s.weight = 1e30F; }));
  EXPECT_FALSE(held([](SurfaceSample& s) { s.theta = 1e308; }));
  EXPECT_FALSE(held([](SurfaceSample& s) { s.radius = 1e308; }));
  EXPECT_FALSE(held([](SurfaceSample& s) { s.z = std::numeric_limits<double>::quiet_NaN(); }));
}

TEST(SampleGrid, TellsHowManyDirectionsTheRingLooksIn) {
  ScanShape shape;
  shape.sensors = 180;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::mt19937_64 random(5);
  std::vector<double> aim(180);
  for (double& a : aim) a = Uniform(random, -0.005, 0.005);  // up to 0.3 degrees beside the nominal direction
  for (SurfaceSample& s : samples) s.theta = WrapAngle(s.theta + aim[s.sensor]);
  EXPECT_EQ(SampleGrid(samples).RingSize(), 180U);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor == 0 || (s.sensor >= 30 && s.sensor < 45); });
  EXPECT_EQ(SampleGrid(samples).columns(), 164U);
  EXPECT_EQ(SampleGrid(samples).RingSize(), 180U);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor >= 90; });  // half a ring
  EXPECT_EQ(SampleGrid(samples).RingSize(), 180U);
}

TEST(CellGrid, LeavesTheColumnsOfDeadSensorsEmpty) {
  ScanShape shape;
  shape.sensors = 180;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor == 17 || (s.sensor >= 60 && s.sensor < 75); });
  const CellGrid cells = CellsOf(samples);
  ASSERT_EQ(cells.columns(), 180U);
  ASSERT_EQ(cells.rows(), 60U);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const bool dead = column == 17 || (column >= 60 && column < 75);
      EXPECT_EQ(cells.count(column, row), dead ? 0U : 1U) << column << ' ' << row;
      const double truth = SmoothTrunk(kTwoPi * static_cast<double>(column) / 180.0, 5.0 * static_cast<double>(row));
      EXPECT_EQ(cells.mean(column, row), dead ? 0.0 : truth) << column << ' ' << row;
    }
  }
}

TEST(CellGrid, LeavesTheRowsOfMissingLevelsEmpty) {
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  std::erase_if(samples, [](const SurfaceSample& s) { return s.level >= 25 && s.level < 35; });
  const CellGrid cells = CellsOf(samples);
  ASSERT_EQ(cells.rows(), 60U);
  for (std::size_t row = 0; row < 60; ++row) EXPECT_EQ(cells.count(3, row), row >= 25 && row < 35 ? 0U : 1U) << row;
}

TEST(CellGrid, HasOneRowPerLevelOfSweepsThatInterleaveUnevenly) {
  // The second sweep runs 0.7 mm above the first: gaps of 0.7 and 4.3 mm in turn.
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, {});
  const std::size_t first = samples.size();
  for (std::size_t k = 0; k < first; ++k) {
    samples.push_back(samples[k]);
    samples.back().sweep = 1;
    samples.back().z += 0.7;
  }
  EXPECT_EQ(CellsOf(samples).rows(), 120U);
}

TEST(BuildKnowledge, IsInferredUpTo40MillimetresOfSkinFromAReturn) {
  // A cylinder of radius 100 mm with a window 50 degrees wide and 120 mm high: on the level in its middle, theta is
  // inferred up to 40 mm of arc (22.9 degrees) from its sides. Cells are 3.49 mm by 5 mm.
  ScanShape shape;
  shape.sensors = 180;
  std::vector<SurfaceSample> samples = SyntheticScan([](double, double) { return 100.0; }, shape);
  std::erase_if(samples,
                [](const SurfaceSample& s) { return s.sensor > 20 && s.sensor < 70 && s.level > 17 && s.level < 42; });
  const CellGrid cells = CellsOf(samples);
  const SplineSurface surface(PeriodicCubicBasis(8), ClampedCubicBasis(UniformBreakpoints(0.0, 295.0, 4)),
                              Eigen::VectorXd::Constant(8 * 7, 100.0));
  const KnowledgeMap map = BuildKnowledge(cells, surface);
  const double arc = 100.0 * kTwoPi / 180.0;
  for (std::size_t column = 20; column <= 70; ++column) {
    const auto steps = static_cast<double>(std::min(column - 20, 70 - column));
    const Knowledge expected = steps <= 1.0          ? Knowledge::kMeasured
                               : steps * arc <= 40.0 ? Knowledge::kInferred
                                                     : Knowledge::kUnknown;
    EXPECT_EQ(map.Cell(column, 30), expected) << column;
  }
  for (std::size_t row = 17; row <= 42; ++row) {
    const auto steps = static_cast<double>(std::min(row - 17, 42 - row));
    const Knowledge expected = steps <= 1.0          ? Knowledge::kMeasured
                               : steps * 5.0 <= 40.0 ? Knowledge::kInferred
                                                     : Knowledge::kUnknown;
    EXPECT_EQ(map.Cell(45, row), expected) << row;
  }
}

TEST(EstimateNoise, DoesNotTakeSlopesForNoiseWhereSamplesStandOffTheGrid) {
  // Slopes of up to 1.5 mm/mm and little bend, every sample up to 0.3 of the pitch off in theta and height: 2 mm of
  // radius.
  const auto radius = [](double theta, double z) {
    return 150.0 + 30.0 * std::cos(2.0 * theta) + 60.0 * std::sin(z / 40.0);
  };
  std::mt19937_64 random(8);
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < 80; ++level) {
    for (std::uint16_t sensor = 0; sensor < 180; ++sensor) {
      SurfaceSample s;
      s.theta = WrapAngle(kTwoPi * (sensor + test::Uniform(random, -0.3, 0.3)) / 180.0);
      s.z = 5.0 * (level + test::Uniform(random, -0.3, 0.3));
      s.radius = radius(s.theta, s.z) + 0.25 * test::Normal(random);
      s.level = level;
      s.sensor = sensor;
      samples.push_back(s);
    }
  }
  const SampleGrid grid(samples);
  EXPECT_NEAR(EstimateNoise(samples, grid, std::vector<SampleVerdict>(samples.size(), SampleVerdict::kGood)), 0.25,
              0.03);
}

TEST(EstimateNoise, IsTheSpreadOfTheReturnsWhateverTheOutliers) {
  const std::vector<SurfaceSample> samples = SpoiledScan(9);
  const SampleGrid grid(samples);
  const std::vector<SampleVerdict> verdicts = VerdictsOf(samples);
  EXPECT_NEAR(EstimateNoise(samples, grid, verdicts), 0.5, 0.04);
  EXPECT_EQ(EstimateNoise({}, SampleGrid({}), {}), 0.0);
}

}  // namespace
}  // namespace annulus
