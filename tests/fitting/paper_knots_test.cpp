#include "fitting/paper_knots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/frames.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

CurveSamples Ring(const std::function<double(double)>& f, double noise = 0.0) {
  std::mt19937_64 random(7);
  CurveSamples samples;
  samples.period = kTwoPi;
  for (int k = 0; k < 180; ++k) {
    samples.x.push_back(kTwoPi * k / 180.0);
    samples.value.push_back(f(samples.x.back()) + (noise > 0.0 ? noise * test::Normal(random) : 0.0));
  }
  samples.weight.assign(180, 1.0);
  return samples;
}

double Wavy(double t) { return 150.0 + 20.0 * std::cos(2.0 * t) + 12.0 * std::cos(3.0 * t); }

KnotPlan PlanOf(const CurveSamples& samples, double noise) {
  const auto slopes = EstimateSlopes(samples);
  return PlaceKnots(samples, slopes, FindFeatures(samples, slopes, noise), KnotRules());
}

// f = x²/2 on x > 0: |f'| = x, so ∫ from x0 to x is (x² - x0²)/2 and the thirds lie at sqrt(x0² + k/3·(x3² - x0²)).
TEST(SplitByVariation, IsExactWhereTheSlopeIsLinear) {
  CurveSamples samples;
  for (int k = 0; k <= 40; ++k) {
    samples.x.push_back(0.5 * k);
    samples.value.push_back(0.125 * k * k);
  }
  samples.weight.assign(samples.x.size(), 1.0);
  const auto slopes = EstimateSlopes(samples);
  for (const auto& [x0, x3] : {std::pair{1.5, 12.0}, std::pair{3.2, 3.9}, std::pair{7.0, 18.5}}) {
    const auto split = SplitByVariation(samples, slopes, x0, x3);
    for (std::size_t part = 0; part < 2; ++part) {
      const double share = static_cast<double>(part + 1) / 3.0;
      EXPECT_NEAR(split[part], std::sqrt(x0 * x0 + share * (x3 * x3 - x0 * x0)), 1e-9);
    }
  }
}

// Between the maximum and the minimum of cos 2θ, |f'| is proportional to sin 2θ: thirds at acos(1/3)/2 and
// acos(-1/3)/2, up to the polyline's error.
TEST(SplitByVariation, FollowsASineWithinATenthOfASample) {
  const CurveSamples samples = Ring([](double t) { return 100.0 + 10.0 * std::cos(2.0 * t); });
  const auto split = SplitByVariation(samples, EstimateSlopes(samples), 0.0, kPi / 2.0);
  EXPECT_NEAR(split[0], std::acos(1.0 / 3.0) / 2.0, 0.1 * kTwoPi / 180.0);
  EXPECT_NEAR(split[1], std::acos(-1.0 / 3.0) / 2.0, 0.1 * kTwoPi / 180.0);
  // The same a turn further, over the seam.
  const auto seam = SplitByVariation(samples, EstimateSlopes(samples), 1.5 * kPi, kTwoPi);
  EXPECT_NEAR(seam[0], 1.5 * kPi + split[0], 1e-3);
}

TEST(SplitByVariation, GivesThirdsWhereNothingChanges) {
  const CurveSamples samples = Ring([](double) { return 0.0; });
  const auto split = SplitByVariation(samples, EstimateSlopes(samples), 1.0, 4.0);
  EXPECT_DOUBLE_EQ(split[0], 2.0);
  EXPECT_DOUBLE_EQ(split[1], 3.0);
}

TEST(LeastSlope, IsOneForEqualDistancesAndNegativeForVeryUnequalOnes) {
  std::vector<double> even;
  for (int k = 0; k < 24; ++k) even.push_back(kTwoPi * k / 24.0);
  EXPECT_NEAR(LeastSlope(even, kTwoPi).slope, 1.0, 1e-12);
  std::vector<double> uneven;
  for (int k = 0; k < 12; ++k) uneven.push_back(0.01 * k);
  for (int k = 0; k < 12; ++k) uneven.push_back(0.5 + 0.45 * k);
  EXPECT_LT(LeastSlope(uneven, kTwoPi).slope, 0.0);
}

// Open with equal distances 1: the differences D_j of the control points obey D_{j-1} + 4 D_j + D_{j+1} = 6 and, by
// Q0 = Q1, D_0 = 0. So D_j = 1 - (√3 - 2)^j away from the other end, and the slope at the end is (D_0 + D_1)/2.
TEST(LeastSlope, OfAnOpenCurveIsThatOfTheEndRule) {
  std::vector<double> even;
  for (int k = 0; k < 60; ++k) even.push_back(7.0 * k);
  const SlopeMinimum least = LeastSlope(even, 0.0);
  EXPECT_NEAR(least.slope, (3.0 - std::sqrt(3.0)) / 2.0, 1e-9);
}

TEST(PlaceKnots, PutsThreeKnotsPerFeatureAndEveryFeatureOnAKnot) {
  const CurveSamples samples = Ring(Wavy);
  const KnotPlan plan = PlanOf(samples, 1e-3);
  EXPECT_EQ(plan.knots.size(), 3 * plan.features.size());
  EXPECT_EQ(plan.dropped, 0U);
  for (std::size_t k = 0; k < plan.features.size(); ++k) EXPECT_EQ(plan.knots[3 * k], plan.features[k].x);
  for (std::size_t k = 1; k < plan.knots.size(); ++k) EXPECT_LT(plan.knots[k - 1], plan.knots[k]);
  EXPECT_GE(LeastSlope(plan.knots, plan.period).slope, KnotRules().least_slope);
}

TEST(PlaceKnots, GivesACircleEightFeaturesOfItsOwn) {
  const KnotPlan plan = PlanOf(Ring([](double) { return 100.0; }), 1e-3);
  EXPECT_EQ(plan.knots.size(), 24U);
  for (const FeaturePoint& feature : plan.features) EXPECT_EQ(feature.kind, FeatureKind::kAdded);
}

TEST(PlaceKnots, BeginsAndEndsAnOpenCurveAtItsEnds) {
  CurveSamples samples;
  for (int k = 0; k < 60; ++k) {
    samples.x.push_back(5.0 * k);
    samples.value.push_back(100.0 + 10.0 * std::sin(0.04 * samples.x.back()));
  }
  samples.weight.assign(60, 1.0);
  const KnotPlan plan = PlanOf(samples, 1e-3);
  EXPECT_EQ(plan.features.front().kind, FeatureKind::kEnd);
  EXPECT_EQ(plan.features.back().kind, FeatureKind::kEnd);
  EXPECT_EQ(plan.knots.front(), 0.0);
  EXPECT_EQ(plan.knots.back(), 295.0);
  EXPECT_EQ(plan.knots.size(), 3 * plan.features.size() - 2);
}

TEST(PlaceKnots, KeepsTheRulesOnAnyCurve) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    // Waves at random, noise that is not announced, a hole.
    std::mt19937_64 random(seed);
    std::array<double, 24> amplitude{};
    for (double& a : amplitude) a = test::Uniform(random, -6.0, 6.0);
    CurveSamples samples = Ring(
        [&](double t) {
          double r = 150.0;
          for (std::size_t k = 0; k < amplitude.size(); ++k) {
            r += amplitude[k] * std::sin(static_cast<double>(k + 1) * t);
          }
          return r;
        },
        0.5);
    for (std::size_t k = 0; k < 15; ++k) samples.weight[(k + 7 * seed) % 180] = 0.0;
    const KnotPlan plan = PlanOf(samples, 1e-3);
    EXPECT_EQ(plan.knots.size(), 3 * plan.features.size());
    EXPECT_LE(plan.features.size(), KnotRules().most_features);
    EXPECT_GE(LeastSlope(plan.knots, plan.period).slope, KnotRules().least_slope);
  }
}

TEST(EvaluateKnotResiduals, HasTheGradientsOfItsValues) {
  const CurveSamples samples = Ring(Wavy, 0.5);
  const KnotPlan plan = PlanOf(samples, 0.5);
  const double lambda = 1e-4;
  const Eigen::VectorXd c =
      150.0 + 10.0 * Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(plan.knots.size()), 0.0, 9.0).array().sin();
  const KnotResiduals all = EvaluateKnotResiduals(samples, plan, lambda, c);
  constexpr double kSmall = 1e-6;
  for (Eigen::Index k = 0; k < c.size(); ++k) {
    Eigen::VectorXd up = c;
    Eigen::VectorXd down = c;
    up[k] += kSmall;
    down[k] -= kSmall;
    const Eigen::VectorXd numeric = (EvaluateKnotResiduals(samples, plan, lambda, up).values -
                                     EvaluateKnotResiduals(samples, plan, lambda, down).values) /
                                    (2.0 * kSmall);
    EXPECT_LE((numeric - all.by_coefficient.col(k)).cwiseAbs().maxCoeff(), 1e-6);
  }
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < plan.knots.size(); ++k) {
    if (k % 3 == 0) continue;
    KnotPlan up = plan;
    KnotPlan down = plan;
    up.knots[k] += kSmall;
    down.knots[k] -= kSmall;
    const Eigen::VectorXd numeric = (EvaluateKnotResiduals(samples, up, lambda, c).values -
                                     EvaluateKnotResiduals(samples, down, lambda, c).values) /
                                    (2.0 * kSmall);
    const double scale = std::max(1.0, all.by_knot.col(column).cwiseAbs().maxCoeff());
    EXPECT_LE((numeric - all.by_knot.col(column)).cwiseAbs().maxCoeff(), 2e-5 * scale) << "knot " << k;
    ++column;
  }
}

TEST(EvaluateKnotResiduals, SumToEquation24) {
  const CurveSamples samples = Ring(Wavy, 0.5);
  const KnotPlan plan = PlanOf(samples, 0.5);
  const double lambda = 1e-4;
  CurveFitter fitter(KnotSplineBasis(plan.knots, plan.period), samples.x, lambda);
  const auto fit = fitter.Fit(samples.value, samples.weight);
  ASSERT_TRUE(fit.has_value());
  const KnotResiduals all = EvaluateKnotResiduals(samples, plan, lambda, fit->coefficients);
  const double sigma = fit->squared_error + lambda * fit->bending;
  EXPECT_NEAR(all.values.squaredNorm(), sigma, 1e-9 * sigma);
  // At the linear solution the gradient with respect to the coefficients vanishes.
  EXPECT_LE((all.by_coefficient.transpose() * all.values).cwiseAbs().maxCoeff(), 1e-7 * sigma);
}

TEST(MoveKnots, LowersEquation24WithinItsRange) {
  const CurveSamples samples =
      Ring([](double t) { return Wavy(t) + 6.0 * std::exp(-200.0 * (t - 2.0) * (t - 2.0)); }, 0.3);
  const KnotPlan plan = PlanOf(samples, 0.3);
  const auto move = MoveKnots(samples, plan, 1e-6, KnotRules());
  ASSERT_TRUE(move.has_value());
  EXPECT_LT(move->cost_end, move->cost_start);
  EXPECT_GE(LeastSlope(move->plan.knots, plan.period).slope, KnotRules().least_slope);
  for (std::size_t k = 0; k < plan.knots.size(); ++k) {
    const double here = plan.knots[k];
    const double moved = move->plan.knots[k];
    if (k % 3 == 0) {
      EXPECT_EQ(moved, here);
      continue;
    }
    const double after = k + 1 < plan.knots.size() ? plan.knots[k + 1] : plan.knots.front() + plan.period;
    EXPECT_GE(moved, here - kKnotRange * (here - plan.knots[k - 1]) - 1e-12);
    EXPECT_LE(moved, here + kKnotRange * (after - here) + 1e-12);
  }
}

}  // namespace
}  // namespace annulus
