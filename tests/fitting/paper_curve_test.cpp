#include "fitting/paper_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/frames.h"

namespace annulus {
namespace {

std::vector<double> Ones(std::size_t n) { return std::vector<double>(n, 1.0); }

TEST(KnotSplineBasis, SumsToOneOverUnequalKnots) {
  const KnotSplineBasis closed({0.2, 0.3, 1.1, 2.5, 4.0, 4.1}, kTwoPi);
  const KnotSplineBasis open({-3.0, -2.9, 1.0, 6.0}, 0.0);
  for (const KnotSplineBasis& basis : {closed, open}) {
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(basis.count()));
    for (double x = -3.0; x <= 6.0; x += 0.01) EXPECT_NEAR(basis.Value(ones, x), 1.0, 1e-13);
  }
}

TEST(KnotSplineBasis, ClosedIsTheSameATurnFurther) {
  const KnotSplineBasis basis({5.0, 6.0, 8.0, 9.5, 10.9}, kTwoPi);  // knots beyond 2 pi, as a plan may have them
  const Eigen::VectorXd c = Eigen::VectorXd::LinSpaced(5, -2.0, 7.0);
  for (double x = 0.0; x < kTwoPi; x += 0.05) EXPECT_NEAR(basis.Value(c, x), basis.Value(c, x + kTwoPi), 1e-12);
}

TEST(CurveFitter, ReproducesAStraightLineWhateverLambda) {
  std::vector<double> x;
  std::vector<double> y;
  for (int k = 0; k < 30; ++k) {
    x.push_back(k * 5.0);
    y.push_back(100.0 + 0.3 * x.back());
  }
  for (const double lambda : {1e-6, 1.0, 1e6}) {
    CurveFitter fitter(KnotSplineBasis({0.0, 10.0, 15.0, 60.0, 145.0}, 0.0), x, lambda);
    const auto fit = fitter.Fit(y, Ones(30));
    ASSERT_TRUE(fit.has_value());
    EXPECT_NEAR(fit->squared_error, 0.0, 1e-12);
    EXPECT_NEAR(fit->bending, 0.0, 1e-12);
    EXPECT_NEAR(fitter.basis().Value(fit->coefficients, 47.3), 114.19, 1e-8);
  }
}

// Knots and samples at the same N equal distances h: on cos(w k) the splines' value symbol is B = (4 + 2 cos w)/6 and
// the bending's P = (2 - 2 cos w)^2 (4 + 2 cos w)/6 / h^3, so the amplitude at the knots is B^2/(B^2 + lambda P).
TEST(CurveFitter, DampsAWaveByItsClosedForm) {
  constexpr std::size_t kCount = 36;
  const double h = kTwoPi / kCount;
  std::vector<double> x;
  std::vector<double> y;
  constexpr int kWaves = 5;
  for (std::size_t k = 0; k < kCount; ++k) {
    x.push_back(h * static_cast<double>(k));
    y.push_back(3.0 * std::cos(kWaves * x.back()));
  }
  const double lambda = 2e-3;
  const double w = kWaves * h;
  const double value = (4.0 + 2.0 * std::cos(w)) / 6.0;
  const double bending = std::pow(2.0 - 2.0 * std::cos(w), 2) * value / (h * h * h);
  const double amplitude = 3.0 * value * value / (value * value + lambda * bending);
  CurveFitter fitter(KnotSplineBasis(x, kTwoPi), x, lambda);
  const auto fit = fitter.Fit(y, Ones(kCount));
  ASSERT_TRUE(fit.has_value());
  for (const double theta : x) {
    EXPECT_NEAR(fitter.basis().Value(fit->coefficients, theta), amplitude * std::cos(kWaves * theta), 1e-10);
  }
  // ∫ f''² by the coefficients' amplitude c: N c² P / 2.
  const double c = amplitude / value;
  EXPECT_NEAR(fit->bending, kCount * c * c * bending / 2.0, 1e-8);
}

// With a knot at every sample the minimum of eq. 2.4 over all curves, the natural smoothing spline, is within reach:
// python3 -c "import numpy as np; from scipy.interpolate import make_smoothing_spline as m
//   x=np.array([0,1,2.5,3,5,6,8,9.]); y=np.array([1,3,2,5,4,4,7,6.]); w=np.array([1,1,.5,1,1,1,1,1])
//   print(m(x,y,w=w,lam=0.7)([0,1,2.5,4,7.2,9]).tolist())"
TEST(CurveFitter, AgreesWithScipysSmoothingSpline) {
  const std::vector<double> x{0, 1, 2.5, 3, 5, 6, 8, 9};
  const std::vector<double> y{1, 3, 2, 5, 4, 4, 7, 6};
  const std::vector<double> w{1, 1, 0.5, 1, 1, 1, 1, 1};
  const std::vector<double> at{0, 1, 2.5, 4, 7.2, 9};
  const std::vector<double> expected{1.3227304478828736, 2.5222281818616845, 3.6968659156284907,
                                     4.147081084929159,  5.540409494620093,  6.4504767996424714};
  CurveFitter fitter(KnotSplineBasis(x, 0.0), x, 0.7);
  const auto fit = fitter.Fit(y, w);
  ASSERT_TRUE(fit.has_value());
  for (std::size_t k = 0; k < at.size(); ++k) {
    EXPECT_NEAR(fitter.basis().Value(fit->coefficients, at[k]), expected[k], 1e-9) << at[k];
  }
}

TEST(CurveFitter, BridgesAHoleWithoutLookingIntoIt) {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> w;
  for (int k = 0; k < 180; ++k) {
    x.push_back(RadiansFromDegrees(2.0 * k));
    const bool hole = k >= 60 && k < 75;
    y.push_back(hole ? 1e300 : 150.0 + 20.0 * std::cos(2.0 * x.back()));
    w.push_back(hole ? 0.0 : 1.0);
  }
  std::vector<double> knots;
  for (int k = 0; k < 24; ++k) knots.push_back(kTwoPi * k / 24.0);
  CurveFitter fitter(KnotSplineBasis(knots, kTwoPi), x, 1e-6);
  const auto fit = fitter.Fit(y, w);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fitter.basis().Value(fit->coefficients, x[67]), 150.0 + 20.0 * std::cos(2.0 * x[67]), 2.0);
}

TEST(CurveFitter, SaysWhenNothingDeterminesTheCurve) {
  const std::vector<double> x{0, 1, 2, 3, 4};
  CurveFitter fitter(KnotSplineBasis({0.0, 4.0}, 0.0), x, 1.0);
  const auto fit = fitter.Fit(x, std::vector<double>{0, 1, 0, 0, 0});
  ASSERT_FALSE(fit.has_value());
  EXPECT_NE(fit.error().Text().find("1 returns"), std::string::npos);
}

TEST(CurveFitter, SpendsBetweenTwoParametersAndAll) {
  std::vector<double> x;
  for (int k = 0; k < 40; ++k) x.push_back(k);
  const KnotSplineBasis basis({0.0, 7.0, 9.0, 20.0, 31.0, 39.0}, 0.0);
  EXPECT_NEAR(CurveFitter(basis, x, 1e-9).EffectiveParameters(Ones(40)), 8.0, 1e-5);
  EXPECT_NEAR(CurveFitter(basis, x, 1e12).EffectiveParameters(Ones(40)), 2.0, 1e-5);
}

TEST(ChooseLambda, SmoothsNoiseAndKeepsAWave) {
  CurveSamples samples;
  samples.period = kTwoPi;
  for (int k = 0; k < 180; ++k) {
    samples.x.push_back(kTwoPi * k / 180.0);
    const double noise = std::fmod(std::abs(std::sin(12.9898 * (k + 1)) * 43758.5453), 1.0) - 0.5;
    samples.value.push_back(100.0 + 10.0 * std::cos(2.0 * samples.x.back()) + noise);
  }
  samples.weight = Ones(180);
  std::vector<double> knots;
  for (int k = 0; k < 60; ++k) knots.push_back(kTwoPi * k / 60.0);
  const KnotSplineBasis basis(knots, kTwoPi);
  const double lambda = ChooseLambda(basis, samples);
  CurveFitter fitter(basis, samples.x, lambda);
  const double spent = fitter.EffectiveParameters(samples.weight);
  EXPECT_LT(spent, 30.0);  // of 60: noise is smoothed
  const auto fit = fitter.Fit(samples.value, samples.weight);
  ASSERT_TRUE(fit.has_value());
  for (const double x : samples.x) {
    EXPECT_NEAR(fitter.basis().Value(fit->coefficients, x), 100.0 + 10.0 * std::cos(2.0 * x), 0.4);
  }
}

}  // namespace
}  // namespace annulus
