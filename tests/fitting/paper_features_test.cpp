#include "fitting/paper_features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/frames.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

constexpr double kStep = kTwoPi / 180.0;
constexpr double kTinyNoise = 1e-3;  // mm

CurveSamples Ring(const std::function<double(double)>& f, double noise = 0.0, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  CurveSamples samples;
  samples.period = kTwoPi;
  for (int k = 0; k < 180; ++k) {
    samples.x.push_back(kStep * k);
    samples.value.push_back(f(samples.x.back()) + (noise > 0.0 ? noise * test::Normal(random) : 0.0));
  }
  samples.weight.assign(180, 1.0);
  return samples;
}

/// Zeros of a function over one turn, by bisection between 1/100 degree steps.
std::vector<double> Zeros(const std::function<double(double)>& g) {
  std::vector<double> zeros;
  constexpr int kParts = 36000;
  for (int k = 0; k < kParts; ++k) {
    double low = kTwoPi * (k + 0.5) / kParts;
    double high = kTwoPi * (k + 1.5) / kParts;
    if (g(low) * g(high) > 0.0) continue;
    for (int n = 0; n < 60; ++n) {
      const double middle = 0.5 * (low + high);
      (g(low) * g(middle) <= 0.0 ? high : low) = middle;
    }
    zeros.push_back(WrapAngle(low));
  }
  return zeros;
}

std::vector<double> Places(const std::vector<FeaturePoint>& features, FeatureKind kind) {
  std::vector<double> places;
  for (const FeaturePoint& feature : features) {
    if (feature.kind == kind) places.push_back(feature.x);
  }
  return places;
}

/// Each expected place has a found one within `tolerance`, and as many were found as expected.
void ExpectSamePlaces(const std::vector<double>& found, const std::vector<double>& expected, double tolerance) {
  EXPECT_EQ(found.size(), expected.size());
  for (const double place : expected) {
    double nearest = kTwoPi;
    for (const double other : found) nearest = std::min(nearest, std::abs(AngleDifference(other, place)));
    EXPECT_LE(nearest, tolerance + 1e-9) << "at " << DegreesFromRadians(place) << " deg";
  }
}

/// r = a + b cos 2θ + c cos 3θ + d sin θ and its derivatives.
struct Wave {
  double b;
  double c;
  double d;
  [[nodiscard]] double F(double t) const {
    return 150.0 + b * std::cos(2.0 * t) + c * std::cos(3.0 * t) + d * std::sin(t);
  }
  [[nodiscard]] double First(double t) const {
    return -2.0 * b * std::sin(2.0 * t) - 3.0 * c * std::sin(3.0 * t) + d * std::cos(t);
  }
  [[nodiscard]] double Second(double t) const {
    return -4.0 * b * std::cos(2.0 * t) - 9.0 * c * std::cos(3.0 * t) - d * std::sin(t);
  }
};

TEST(EstimateSlopes, IsExactForACubic) {
  CurveSamples samples;
  for (int k = 0; k < 25; ++k) {
    const double x = 5.0 * k;
    samples.x.push_back(x);
    samples.value.push_back(2.0 - 0.3 * x + 0.02 * x * x - 1e-4 * x * x * x);
  }
  samples.weight.assign(25, 1.0);
  const auto slopes = EstimateSlopes(samples);
  for (std::size_t k = 0; k < 25; ++k) {
    const double x = samples.x[k];
    EXPECT_EQ(slopes[k].known, k >= 2 && k <= 22);  // at least two samples on both sides
    if (!slopes[k].known) continue;
    EXPECT_NEAR(slopes[k].first, -0.3 + 0.04 * x - 3e-4 * x * x, 1e-10);
    EXPECT_NEAR(slopes[k].second, 0.04 - 6e-4 * x, 1e-11);
  }
}

// Equal distances h, 2K+1 = 11: with S2 = Σj² = 110, S4 = Σj⁴ = 1958, S6 = Σj⁶ = 41030 the variances of c1 and c2 are
// S6/(S2·S6 - S4²)/h² and 1/(S4 - S2²/11)/h⁴.
TEST(EstimateSlopes, KnowsItsOwnNoise) {
  const auto slopes = EstimateSlopes(Ring([](double) { return 100.0; }));
  const double first = std::sqrt(41030.0 / (110.0 * 41030.0 - 1958.0 * 1958.0)) / kStep;
  const double second = 2.0 / std::sqrt(1958.0 - 110.0 * 110.0 / 11.0) / (kStep * kStep);
  for (const SlopeEstimate& slope : slopes) {
    EXPECT_NEAR(slope.first_gain, first, 1e-9 * first);
    EXPECT_NEAR(slope.second_gain, second, 1e-9 * second);
  }
}

TEST(EstimateSlopes, TakesWhatAHoleLeavesAndSaysWhenThatIsTooLittle) {
  CurveSamples samples = Ring([](double t) { return 100.0 + std::sin(t); });
  for (std::size_t k = 40; k < 52; ++k) {
    samples.weight[k] = 0.0;
    samples.value[k] = std::nan("");
  }
  const auto slopes = EstimateSlopes(samples);
  EXPECT_FALSE(slopes[45].known);
  EXPECT_TRUE(slopes[37].known);
  EXPECT_GT(slopes[37].first_gain, slopes[20].first_gain);
  EXPECT_NEAR(slopes[37].first, std::cos(samples.x[37]), 1e-4);
}

// The two-sided normal quantiles of 0.05/180 and 0.05/1000, scipy.stats.norm.isf(0.025/180), isf(0.025/1000).
TEST(SignificanceGate, IsBonferronis) {
  EXPECT_NEAR(SignificanceGate(180), 3.6351881983520986, 1e-9);
  EXPECT_NEAR(SignificanceGate(1000), 4.0556269811224, 1e-9);
}

class AnalyticFeatures : public testing::TestWithParam<Wave> {};

TEST_P(AnalyticFeatures, AreFoundWithinOneSample) {
  const Wave wave = GetParam();
  const CurveSamples samples = Ring([&](double t) { return wave.F(t); });
  const auto features = FindFeatures(samples, EstimateSlopes(samples), kTinyNoise);
  ExpectSamePlaces(Places(features, FeatureKind::kExtremum), Zeros([&](double t) { return wave.First(t); }), kStep);
  ExpectSamePlaces(Places(features, FeatureKind::kInflection), Zeros([&](double t) { return wave.Second(t); }), kStep);
}

INSTANTIATE_TEST_SUITE_P(Waves, AnalyticFeatures,
                         testing::Values(Wave{20.0, 0.0, 0.0}, Wave{20.0, 12.0, 0.0}, Wave{30.0, 5.0, 4.0},
                                         Wave{15.0, 15.0, -7.0}, Wave{0.0, 9.0, 1.0}));

TEST(FindFeatures, TakesTheLastSampleBeforeTheSignFlips) {
  // cos(2(t - 0.3 step)) has its extrema 0.3 of a step after every 45th sample.
  const CurveSamples samples = Ring([](double t) { return 100.0 + 10.0 * std::cos(2.0 * (t - 0.3 * kStep)); });
  const auto extrema = Places(FindFeatures(samples, EstimateSlopes(samples), kTinyNoise), FeatureKind::kExtremum);
  ASSERT_EQ(extrema.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(extrema[k], kPi / 2.0 * static_cast<double>(k), 1e-12);
}

TEST(FindFeatures, SeesNoneInNoise) {
  std::size_t with_features = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const CurveSamples samples = Ring([](double) { return 120.0; }, 0.5, seed);
    with_features += FindFeatures(samples, EstimateSlopes(samples), 0.5).empty() ? 0 : 1;
  }
  EXPECT_LE(with_features, 20U);  // 5 % each of f' and f'' would be 20
}

TEST(FindFeatures, KeepsThemUnderNoise) {
  const Wave wave{5.0, 20.0, 0.0};
  const auto extrema = Zeros([&](double t) { return wave.First(t); });
  const auto inflections = Zeros([&](double t) { return wave.Second(t); });
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CurveSamples samples = Ring([&](double t) { return wave.F(t); }, 0.3, seed);
    const auto features = FindFeatures(samples, EstimateSlopes(samples), 0.3);
    ExpectSamePlaces(Places(features, FeatureKind::kExtremum), extrema, 2.0 * kStep);
    ExpectSamePlaces(Places(features, FeatureKind::kInflection), inflections, 3.0 * kStep);
  }
}

TEST(FindFeatures, InventsNoneInAHole) {
  CurveSamples samples = Ring([](double t) { return 100.0 + 10.0 * std::cos(2.0 * t); });
  for (std::size_t k = 80; k < 105; ++k) samples.weight[k] = 0.0;  // the extremum at 180 degrees
  const auto extrema = Places(FindFeatures(samples, EstimateSlopes(samples), kTinyNoise), FeatureKind::kExtremum);
  ExpectSamePlaces(extrema, {0.0, kPi / 2.0, 1.5 * kPi}, kStep);
}

TEST(MeasureComplexity, RanksByFeaturesThenByBending) {
  EXPECT_LT((Complexity{3, 900.0}), (Complexity{4, 1.0}));
  EXPECT_LT((Complexity{4, 1.0}), (Complexity{4, 2.0}));
  // ∫ |f''| of a cos 2θ is 16 a: four half waves of 2a each, times 2.
  const CurveSamples samples = Ring([](double t) { return 100.0 + 10.0 * std::cos(2.0 * t); });
  const auto slopes = EstimateSlopes(samples);
  EXPECT_NEAR(MeasureComplexity(samples, slopes, {}).bending, 160.0, 4.0);
}

}  // namespace
}  // namespace annulus
