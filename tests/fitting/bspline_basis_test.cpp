#include "fitting/bspline_basis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

/// Uniform in [low, high), the same with every standard library.
double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

double Sum(const std::array<double, 4>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Values of all splines at one place, from the four that are not zero.
std::vector<double> Dense(const CubicBasis& basis, const std::array<double, 4>& values, std::size_t count) {
  std::vector<double> dense(count, 0.0);
  for (std::size_t k = 0; k < 4; ++k) dense[basis.index[k]] += values[k];
  return dense;
}

/// Breakpoints with steps between 0.01 and 100, seeded.
std::vector<double> RandomBreakpoints(std::mt19937_64& random) {
  std::vector<double> points{Uniform(random, -500.0, 500.0)};
  const auto intervals = 1 + random() % 12;
  for (std::size_t k = 0; k < intervals; ++k) {
    points.push_back(points.back() + std::pow(10.0, Uniform(random, -2.0, 2.0)));
  }
  return points;
}

/// What is true of every cubic B-spline basis at every place.
void ExpectBasisProperties(const CubicBasis& basis, double spacing, std::size_t count) {
  EXPECT_NEAR(Sum(basis.value), 1.0, 1e-13);
  EXPECT_NEAR(Sum(basis.first) * spacing, 0.0, 1e-11);
  EXPECT_NEAR(Sum(basis.second) * spacing * spacing, 0.0, 1e-11);
  for (const double value : basis.value) {
    EXPECT_GE(value, -1e-16);
    EXPECT_LE(value, 1.0 + 1e-14);
  }
  EXPECT_EQ(std::set<std::size_t>(basis.index.begin(), basis.index.end()).size(), 4U);
  for (const std::size_t index : basis.index) EXPECT_LT(index, count);
}

TEST(PeriodicCubicBasis, SumsToOneAndItsDerivativesToZeroEverywhere) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 2000; ++k) {
    const PeriodicCubicBasis splines(4 + random() % 200);
    ExpectBasisProperties(splines.At(Uniform(random, -20.0, 20.0)), splines.spacing(), splines.count());
  }
}

TEST(PeriodicCubicBasis, IsOneSixthTwoThirdsOneSixthAtItsKnots) {
  const PeriodicCubicBasis splines(12);
  for (std::size_t i = 0; i < 12; ++i) {
    const double knot = static_cast<double>(i) * splines.spacing();
    const std::vector<double> values = Dense(splines.At(knot), splines.At(knot).value, 12);
    EXPECT_NEAR(values[(i + 11) % 12], 1.0 / 6.0, 1e-14) << i;
    EXPECT_NEAR(values[i], 2.0 / 3.0, 1e-14) << i;
    EXPECT_NEAR(values[(i + 1) % 12], 1.0 / 6.0, 1e-14) << i;
    // Derivatives of the cardinal cubic at its knots: ∓1/(2h), 0; 1/h², -2/h², 1/h².
    const double h = splines.spacing();
    const std::vector<double> first = Dense(splines.At(knot), splines.At(knot).first, 12);
    EXPECT_NEAR(first[(i + 11) % 12] * h, -0.5, 1e-12);
    EXPECT_NEAR(first[i] * h, 0.0, 1e-12);
    EXPECT_NEAR(first[(i + 1) % 12] * h, 0.5, 1e-12);
    const std::vector<double> second = Dense(splines.At(knot), splines.At(knot).second, 12);
    EXPECT_NEAR(second[i] * h * h, -2.0, 1e-12);
    EXPECT_NEAR(second[(i + 1) % 12] * h * h, 1.0, 1e-12);
  }
}

TEST(PeriodicCubicBasis, IsTheSameAfterWholeTurns) {
  const PeriodicCubicBasis splines(48);
  std::mt19937_64 random(2);
  for (int k = 0; k < 500; ++k) {
    const double theta = Uniform(random, 0.0, kTwoPi);
    const auto here = Dense(splines.At(theta), splines.At(theta).value, 48);
    const auto there = Dense(splines.At(theta - 3.0 * kTwoPi), splines.At(theta - 3.0 * kTwoPi).value, 48);
    for (std::size_t i = 0; i < 48; ++i) EXPECT_NEAR(here[i], there[i], 1e-12);
  }
}

TEST(PeriodicCubicBasis, ClosesWithTwoContinuousDerivatives) {
  const PeriodicCubicBasis splines(10);
  const double before = std::nextafter(kTwoPi, 0.0);
  for (const auto member : {&CubicBasis::value, &CubicBasis::first, &CubicBasis::second}) {
    const auto at_zero = Dense(splines.At(0.0), splines.At(0.0).*member, 10);
    const auto at_end = Dense(splines.At(before), splines.At(before).*member, 10);
    for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(at_zero[i], at_end[i], 1e-12);
  }
}

TEST(PeriodicCubicBasis, TakesTinyNegativeAndHugeAngles) {
  const PeriodicCubicBasis splines(4);
  for (const double theta : {-1e-18, -5e-324, 1e15, -1e15, 1e308, kTwoPi, -kTwoPi}) {
    ExpectBasisProperties(splines.At(theta), splines.spacing(), 4);
  }
}

TEST(PeriodicCubicBasis, NeedsFourIntervals) { EXPECT_THROW(PeriodicCubicBasis(3), LogicError); }

TEST(PeriodicCubicBasis, HasTheDerivativesThatDifferencesShow) {
  const PeriodicCubicBasis splines(17);
  std::mt19937_64 random(3);
  const double step = 1e-5;
  for (int k = 0; k < 300; ++k) {
    const double theta = Uniform(random, 0.0, kTwoPi);
    const auto at = [&](double t, const std::array<double, 4> CubicBasis::*member) {
      return Dense(splines.At(t), splines.At(t).*member, 17);
    };
    const auto below = at(theta - step, &CubicBasis::value);
    const auto above = at(theta + step, &CubicBasis::value);
    const auto first = at(theta, &CubicBasis::first);
    const auto first_below = at(theta - step, &CubicBasis::first);
    const auto first_above = at(theta + step, &CubicBasis::first);
    const auto second = at(theta, &CubicBasis::second);
    for (std::size_t i = 0; i < 17; ++i) {
      EXPECT_NEAR((above[i] - below[i]) / (2.0 * step), first[i], 1e-7);
      // Second derivatives are piecewise linear: a step across a knot errs by up to step · 4/h³.
      EXPECT_NEAR((first_above[i] - first_below[i]) / (2.0 * step), second[i], 1e-3);
    }
  }
}

TEST(ClampedCubicBasis, AgreesWithScipy) {
  // from scipy.interpolate import BSpline; import numpy as np
  // t = np.r_[[0]*3, [0, 1, 2.5, 3, 7], [7]*3]
  // [BSpline(t, np.eye(7)[i], 3)(x) for i in range(7)], and .derivative(1)(x), .derivative(2)(x)
  const ClampedCubicBasis splines({0.0, 1.0, 2.5, 3.0, 7.0});
  ASSERT_EQ(splines.count(), 7U);
  struct Row {
    double x;
    std::array<double, 4> CubicBasis::*member;
    std::vector<double> expected;
  };
  const std::vector<Row> rows{
      {0.25, &CubicBasis::value, {0.421875, 0.511875, 0.064166666666666664, 0.0020833333333333333, 0.0, 0.0, 0.0}},
      {0.25, &CubicBasis::first, {-1.6875, 1.1925, 0.47, 0.025, 0.0, 0.0, 0.0}},
      {0.25, &CubicBasis::second, {4.5, -6.06, 1.36, 0.2, 0.0, 0.0, 0.0}},
      {2.0,
       &CubicBasis::value,
       {0.0, 0.013333333333333332, 0.2533333333333333, 0.67777777777777781, 0.055555555555555552, 0.0, 0.0}},
      {2.0, &CubicBasis::first, {0.0, -0.08, -0.52, 0.43333333333333335, 0.16666666666666666, 0.0, 0.0}},
      {2.0, &CubicBasis::second, {0.0, 0.32, 0.08, -0.73333333333333339, 0.33333333333333331, 0.0, 0.0}},
      {3.0, &CubicBasis::value, {0.0, 0.0, 0.0, 0.59259259259259256, 0.39506172839506171, 0.012345679012345678, 0.0}},
      {3.0, &CubicBasis::second, {0.0, 0.0, 0.0, 0.22222222222222221, -0.51851851851851849, 0.29629629629629628, 0.0}},
      {6.5,
       &CubicBasis::value,
       {0.0, 0.0, 0.0, 0.0011574074074074073, 0.037229938271604937, 0.29169077932098764, 0.669921875}},
      {6.5,
       &CubicBasis::first,
       {0.0, 0.0, 0.0, -0.0069444444444444441, -0.14004629629629628, -0.4272280092592593, 0.57421875}},
      {6.5,
       &CubicBasis::second,
       {0.0, 0.0, 0.0, 0.027777777777777776, 0.2268518518518518, -0.58275462962962954, 0.328125}},
  };
  for (const Row& row : rows) {
    const CubicBasis basis = splines.At(row.x);
    const std::vector<double> dense = Dense(basis, basis.*row.member, 7);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(dense[i], row.expected[i], 1e-14) << row.x << " spline " << i;
  }
}

TEST(ClampedCubicBasis, SumsToOneAndItsDerivativesToZeroForAnyKnots) {
  std::mt19937_64 random(4);
  for (int k = 0; k < 2000; ++k) {
    const std::vector<double> points = RandomBreakpoints(random);
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < points.size(); ++i) shortest = std::min(shortest, points[i] - points[i - 1]);
    const ClampedCubicBasis splines(points);
    ExpectBasisProperties(splines.At(Uniform(random, splines.min(), splines.max())), shortest, splines.count());
  }
}

TEST(ClampedCubicBasis, InterpolatesItsFirstAndLastCoefficient) {
  const ClampedCubicBasis splines({-3.0, 0.0, 10.0, 11.0});
  EXPECT_EQ(Dense(splines.At(-3.0), splines.At(-3.0).value, 6), (std::vector<double>{1, 0, 0, 0, 0, 0}));
  const auto last = Dense(splines.At(11.0), splines.At(11.0).value, 6);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(last[i], i == 5 ? 1.0 : 0.0, 1e-15);
}

TEST(ClampedCubicBasis, IsContinuousWithTwoDerivativesAcrossItsKnots) {
  const ClampedCubicBasis splines({0.0, 1.0, 2.5, 3.0, 7.0});
  for (const double knot : {1.0, 2.5, 3.0}) {
    for (const auto member : {&CubicBasis::value, &CubicBasis::first, &CubicBasis::second}) {
      const double before = std::nextafter(knot, 0.0);
      const auto left = Dense(splines.At(before), splines.At(before).*member, 7);
      const auto right = Dense(splines.At(knot), splines.At(knot).*member, 7);
      for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(left[i], right[i], 1e-12);
    }
  }
}

TEST(ClampedCubicBasis, ReproducesALineFromGrevilleAbscissas) {
  // Marsden: x = Σ ξ_i N_i(x) with ξ_i = (t_{i+1} + t_{i+2} + t_{i+3})/3.
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> points = RandomBreakpoints(random);
    std::vector<double> knots(3, points.front());
    knots.insert(knots.end(), points.begin(), points.end());
    knots.insert(knots.end(), 3, points.back());
    const ClampedCubicBasis splines(points);
    const double x = Uniform(random, splines.min(), splines.max());
    const CubicBasis basis = splines.At(x);
    double value = 0.0;
    double slope = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = basis.index[k];
      const double greville = (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0;
      value += greville * basis.value[k];
      slope += greville * basis.first[k];
    }
    EXPECT_NEAR(value, x, 1e-10);
    EXPECT_NEAR(slope, 1.0, 1e-8);
  }
}

TEST(ClampedCubicBasis, ReproducesACubicByMarsdensIdentity) {
  // (x - y)³ = Σ (t_{i+1} - y)(t_{i+2} - y)(t_{i+3} - y) N_i(x)  with y = 2.
  const std::vector<double> points{0.0, 1.0, 2.5, 3.0, 7.0};
  std::vector<double> knots(3, points.front());
  knots.insert(knots.end(), points.begin(), points.end());
  knots.insert(knots.end(), 3, points.back());
  const ClampedCubicBasis splines(points);
  const double y = 2.0;
  for (double x = 0.0; x <= 7.0; x += 0.125) {
    const CubicBasis basis = splines.At(x);
    double value = 0.0;
    double first = 0.0;
    double second = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = basis.index[k];
      const double dual = (knots[i + 1] - y) * (knots[i + 2] - y) * (knots[i + 3] - y);
      value += dual * basis.value[k];
      first += dual * basis.first[k];
      second += dual * basis.second[k];
    }
    EXPECT_NEAR(value, (x - y) * (x - y) * (x - y), 1e-12);
    EXPECT_NEAR(first, 3.0 * (x - y) * (x - y), 1e-11);
    EXPECT_NEAR(second, 6.0 * (x - y), 1e-11);
  }
}

TEST(ClampedCubicBasis, ContinuesTheEndPolynomialOutside) {
  const std::vector<double> points{0.0, 1.0, 2.0};
  const ClampedCubicBasis splines(points);
  // A line stays that line outside: Greville abscissas 0, 1/3, 1, 5/3, 2.
  const std::array<double, 5> greville{0.0, 1.0 / 3.0, 1.0, 5.0 / 3.0, 2.0};
  for (const double x : {-0.75, 2.5}) {
    const CubicBasis basis = splines.At(x);
    double value = 0.0;
    for (std::size_t k = 0; k < 4; ++k) value += greville[basis.index[k]] * basis.value[k];
    EXPECT_NEAR(value, x, 1e-12);
  }
}

TEST(ClampedCubicBasis, RefusesBreakpointsThatDoNotIncrease) {
  EXPECT_THROW(ClampedCubicBasis({1.0}), LogicError);
  EXPECT_THROW(ClampedCubicBasis({1.0, 1.0}), LogicError);
  EXPECT_THROW(ClampedCubicBasis({2.0, 1.0}), LogicError);
  EXPECT_THROW(ClampedCubicBasis({0.0, std::numeric_limits<double>::quiet_NaN()}), LogicError);
  EXPECT_THROW(ClampedCubicBasis({0.0, std::numeric_limits<double>::infinity()}), LogicError);
}

TEST(UniformBreakpoints, AreEqualStepsThatEndExactly) {
  const std::vector<double> points = UniformBreakpoints(0.1, 0.7, 3);
  ASSERT_EQ(points.size(), 4U);
  EXPECT_EQ(points.front(), 0.1);
  EXPECT_EQ(points.back(), 0.7);
  EXPECT_NEAR(points[1], 0.3, 1e-15);
  EXPECT_THROW((void)UniformBreakpoints(1.0, 1.0, 3), LogicError);
  EXPECT_THROW((void)UniformBreakpoints(0.0, 1.0, 0), LogicError);
}

}  // namespace
}  // namespace annulus
