#include "modeling/landmarks/level_vertex.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

std::vector<double> Breaks(double from, double to, int count) {
  return UniformBreakpoints(from, to, std::size_t(count));
}

/// Elliptic sections of constant shape whose size is a cubic polynomial of the height, which splines hold exactly.
double Size(double z) { return 100.0 + 1e-3 * (z - 200.0) * (z - 200.0) + 2e-6 * std::pow(z - 200.0, 3); }
SurfaceModel Waisted() {
  return test::InterpolatedBody([](double theta, double z) { return Size(z) * (1.0 + 0.05 * std::cos(2.0 * theta)); },
                                60, Breaks(0.0, 400.0, 20));
}

HeightFunction Tape(const SplineSurface& surface) { return TapeOver(SectionSampler(surface, EvenDirections(360))); }

TEST(LevelVertex, OfACubicIsItsExactExtremum) {
  // Size'(z) = 0 at z = 200: the tape is proportional to the size, because sections are similar.
  const SurfaceModel model = Waisted();
  const SplineSurface& surface = model.main().surface;
  for (const double start : {180.0, 200.0, 225.0}) {
    const auto vertex = FindLevelVertex(surface, Tape(surface), start, 25.0, Extremum::kSmallest);
    ASSERT_TRUE(vertex.has_value()) << start;
    EXPECT_NEAR(vertex->value, 200.0, 1e-4) << start;
  }
  EXPECT_FALSE(FindLevelVertex(surface, Tape(surface), 200.0, 25.0, Extremum::kLargest).has_value());
}

TEST(LevelVertex, LeavesTheSurfaceNowhere) {
  const SurfaceModel model = Waisted();
  const SplineSurface& surface = model.main().surface;
  EXPECT_FALSE(FindLevelVertex(surface, Tape(surface), 10.0, 25.0, Extremum::kSmallest).has_value());
  EXPECT_FALSE(FindLevelVertex(surface, Tape(surface), 200.0, 500.0, Extremum::kSmallest).has_value());
}

/// The change of a height per change of one coefficient, by central differences of what `find` finds.
template <class Find>
double NumericalSlope(const SurfaceModel& model, Eigen::Index index, const Find& find) {
  constexpr double kStep = 0.01;  // mm
  double found[2] = {0.0, 0.0};
  for (const int side : {0, 1}) {
    SurfaceModel moved = model;
    Eigen::VectorXd c = moved.main().surface.coefficients();
    c[index] += side == 0 ? -kStep : kStep;
    moved.segments.front().surface =
        SplineSurface(moved.main().surface.theta_basis(), moved.main().surface.z_basis(), c);
    found[side] = find(moved.main().surface).value;
  }
  return (found[1] - found[0]) / (2.0 * kStep);
}

template <class Find>
void ExpectGradient(const SurfaceModel& model, const Find& find, double tolerance) {
  const Estimate estimate = find(model.main().surface);
  const Eigen::VectorXd gradient = estimate.gradient;
  Eigen::Index largest = 0;
  gradient.cwiseAbs().maxCoeff(&largest);
  for (const Eigen::Index index : {largest, largest + 3, largest - 60, Eigen::Index(0)}) {
    const double scale = std::abs(gradient[largest]);
    EXPECT_NEAR(gradient[index], NumericalSlope(model, index, find), tolerance * scale) << index;
  }
}

TEST(LevelVertex, FollowsTheCoefficientsAsItsGradientSays) {
  ExpectGradient(
      Waisted(), [](const SplineSurface& s) { return *FindLevelVertex(s, Tape(s), 205.0, 25.0, Extremum::kSmallest); },
      1e-3);
}

TEST(LevelCrossing, OfAnOutlineIsWhereItSlopesAsAsked) {
  // r = Size(z)·1.05 towards theta = 0; Size' = 2e-3 d + 6e-6 d² with d = z - 200. The fitted line's slope over ± h of
  // a cubic a·d³ is a·(3 d² + 3 h² m4/m2) with m2, m4 the nodes' mean powers: 5/12 and 0.2762 for nine even nodes.
  const SurfaceModel model = Waisted();
  const SplineSurface& surface = model.main().surface;
  const HeightFunction reach = ReachOver(SectionSampler(surface, EvenDirections(360)), 0.0, 1.0);
  constexpr double kHalf = 10.0;
  const auto found = FindCrossing(surface, SlopeOf(reach, kHalf), {200.0, 390.0, 0.2, Crossing::kRising});
  ASSERT_TRUE(found.has_value());
  double m2 = 0.0;
  double m4 = 0.0;
  for (int k = -4; k <= 4; ++k) {
    m2 += std::pow(k / 4.0, 2);
    m4 += std::pow(k / 4.0, 4);
  }
  const double d = found->value - 200.0;
  EXPECT_NEAR(1.05 * (2e-3 * d + 2e-6 * (3.0 * d * d + kHalf * kHalf * m4 / m2)), 0.2, 1e-6);
  EXPECT_FALSE(FindCrossing(surface, SlopeOf(reach, kHalf), {200.0, 390.0, 0.2, Crossing::kFalling}).has_value());
  EXPECT_FALSE(FindCrossing(surface, SlopeOf(reach, kHalf), {200.0, 100.0, 0.2, Crossing::kEither}).has_value());
}

TEST(LevelCrossing, FollowsTheCoefficientsAsItsGradientSays) {
  const auto find = [](const SplineSurface& s) {
    const HeightFunction reach = ReachOver(SectionSampler(s, EvenDirections(360)), 0.3, 1.0);
    return *FindCrossing(s, SlopeOf(reach, 10.0), {200.0, 390.0, 0.2, Crossing::kRising});
  };
  ExpectGradient(Waisted(), find, 5e-3);
}

TEST(BendOf, AParabolaIsItsSecondDerivative) {
  const SurfaceModel model =
      test::InterpolatedBody([](double, double z) { return 80.0 + 0.002 * z * z; }, 24, Breaks(0.0, 200.0, 10));
  const HeightFunction reach = ReachOver(SectionSampler(model.main().surface, EvenDirections(60)), 0.0, 0.5);
  EXPECT_NEAR(BendOf(reach, 15.0).value(100.0), 0.004, 1e-9);
  EXPECT_NEAR(TangentOf(reach, 15.0).value(100.0), 0.4, 1e-9);
}

TEST(SectionSampler, HullOfAStarIsItsConvexHull) {
  // Eight tips at radius 2 between notches at radius 1: the hull is the octagon of the tips, 16·2·sin(pi/8) around.
  std::vector<Eigen::Vector2d> star;
  for (int k = 0; k < 16; ++k) {
    const double radius = k % 2 == 0 ? 2.0 : 1.0;
    star.emplace_back(radius * std::cos(kPi * k / 8.0), radius * std::sin(kPi * k / 8.0));
  }
  EXPECT_EQ(HullOfSection(star).size(), 8U);
  EXPECT_NEAR(TapeLength(star), 16.0 * 2.0 * std::sin(kPi / 8.0), 1e-12);
  EXPECT_LT(Centroid(star).norm(), 1e-12);
}

}  // namespace
}  // namespace annulus
