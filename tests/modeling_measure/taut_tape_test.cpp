#include "modeling/measure/taut_tape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "modeling/measure/geodesic.h"
#include "modeling/measure/section.h"
#include "tests/modeling_measure/bumpy_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;

double Length(const Result<SurfaceDistance>& distance) {
  if (!distance) throw std::runtime_error(distance.error().Text());
  return distance->length.value;
}

std::vector<double> Breaks() { return UniformBreakpoints(-100.0, 200.0, 150); }

/// How deep the polygon through a path's points enters the body, mm along the normal.
double DepthOfPath(const SplineSurface& surface, const std::vector<PathPoint>& path) {
  double depth = 0.0;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    for (double t = 0.05; t < 1.0; t += 0.1) {
      const Eigen::Vector3d p = path[k].position + t * (path[k + 1].position - path[k].position);
      const double theta = std::atan2(p.y(), p.x());
      const double inside = surface.Radius(theta, p.z()) - p.head<2>().norm();
      if (inside > 0.0) depth = std::max(depth, inside * surface.Normal(theta, p.z()).head<2>().norm());
    }
  }
  return depth;
}

TEST(TautTape, OnAConvexBodyIsTheGeodesic) {
  const SurfaceModel model = InterpolatedBody([](double, double z) { return std::sqrt(1e4 - z * z); }, 12,
                                              UniformBreakpoints(-80.0, 80.0, 160));
  const auto body = MeasuredSurface::FromModel(model);
  for (const auto& [from, to] :
       {std::pair<SurfacePlace, SurfacePlace>{{0.3, -50.0}, {2.0, 60.0}}, {{6.0, -50.0}, {1.0, 10.0}}}) {
    const Eigen::Vector3d a = PointFromCylindrical(from.theta, std::sqrt(1e4 - from.z * from.z), from.z);
    const Eigen::Vector3d b = PointFromCylindrical(to.theta, std::sqrt(1e4 - to.z * to.z), to.z);
    const double expected = 100.0 * std::acos(a.dot(b) / 1e4);
    const auto tape = TautTape(*body, from, to);
    EXPECT_NEAR(Length(tape), expected, 1e-6 * expected);
    EXPECT_LT(DepthOfPath(body->surface(), tape->path), kTapeDepth);
  }
}

TEST(TautTape, SpansAGrooveStraight) {
  const SurfaceModel model =
      InterpolatedBody([](double, double z) { return 95.0 + 5.0 * std::cos(kTwoPi * z / 100.0); }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_NEAR(Length(TautTape(*body, {2.0, 0.0}, {2.0, 100.0})), 100.0, 1e-6);
}

TEST(TautTape, LiesOnABulgeBetweenTwoHollows) {
  // Along the bulge of r = 95 + 5 cos(kz), k = 2π/100, from z = -50 to 50: the tangents from both ends and the arc.
  // from scipy.optimize import brentq; from scipy.integrate import quad; import numpy as np; k = 2*np.pi/100
  // t = brentq(lambda t: 5+5*np.cos(k*t) - 5*k*np.sin(k*t)*(50-t), 1, 30)
  // 2*(quad(lambda z: np.hypot(1, 5*k*np.sin(k*z)), 0, t)[0] + np.hypot(50-t, 5+5*np.cos(k*t)))
  const SurfaceModel model =
      InterpolatedBody([](double, double z) { return 95.0 + 5.0 * std::cos(kTwoPi * z / 100.0); }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  const auto tape = TautTape(*body, {2.0, -50.0}, {2.0, 50.0});
  EXPECT_NEAR(Length(tape), 102.140736715, 1e-4);
  EXPECT_LT(DepthOfPath(body->surface(), tape->path), kTapeDepth);
}

TEST(TautTape, IsTheChordOverADeepDentOfASphere) {
  // A dent of 40 mm around (theta 1, z 0); the chord between its shoulders passes over it and inside the sphere.
  const auto dented = [](double theta, double z) {
    const double square = std::pow(100.0 * AngleDifference(theta, 1.0) / 40.0, 2) + std::pow(z / 40.0, 2);
    return std::sqrt(1e4 - z * z) - 40.0 * std::exp(-square * square);
  };
  const SurfaceModel model = InterpolatedBody(dented, 180, UniformBreakpoints(-80.0, 80.0, 80));
  const auto body = MeasuredSurface::FromModel(model);
  const SurfacePlace from{0.68, 3.0};
  const SurfacePlace to{1.33, -4.0};
  const Eigen::Vector3d a = body->surface().Point(from.theta, from.z);
  const Eigen::Vector3d b = body->surface().Point(to.theta, to.z);
  for (double t = 0.02; t < 1.0; t += 0.02) {
    const Eigen::Vector3d p = a + t * (b - a);
    ASSERT_GT(p.head<2>().norm(), body->surface().Radius(std::atan2(p.y(), p.x()), p.z())) << "the chord is free";
  }
  EXPECT_NEAR(Length(TautTape(*body, from, to)), (b - a).norm(), 1e-9);
}

TEST(TautTape, LiesBetweenChordAndGeodesicAndDoesNotEnterTheBody) {
  const SurfaceModel model = test::BumpyBody();
  const auto body = MeasuredSurface::FromModel(model);
  std::mt19937_64 random(17);
  for (int k = 0; k < 25; ++k) {
    const SurfacePlace a = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace b = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace c = test::RandomPlace(random, 20.0, 280.0);
    const auto tape = TautTape(*body, a, b);
    const double length = Length(tape);
    EXPECT_EQ(length, Length(TautTape(*body, b, a)));
    EXPECT_LE(length, Length(GeodesicDistance(*body, a, b)) + 1e-4);
    EXPECT_LE(length, Length(TautTape(*body, a, c)) + Length(TautTape(*body, c, b)) + 1e-4);
    EXPECT_GE(length, (body->surface().Point(a.theta, a.z) - body->surface().Point(b.theta, b.z)).norm() - 1e-9);
    EXPECT_LT(DepthOfPath(body->surface(), tape->path), kTapeDepth) << k;
  }
}

TEST(TautTape, FollowsTheSurfaceAsItsGradientSays) {
  const SurfaceModel model = test::BumpyBody();
  std::mt19937_64 random(18);
  for (std::uint64_t k = 0; k < 4; ++k) {
    const SurfacePlace a = test::RandomPlace(random, 20.0, 280.0);
    const SurfacePlace b = test::RandomPlace(random, 20.0, 280.0);
    const auto tape = test::DerivativesOf(
        model, [&](const MeasuredSurface& body) { return TautTape(body, a, b); }, k);
    EXPECT_NEAR(tape.by_gradient, tape.by_differences, 3e-3) << k;
    const auto loop = test::DerivativesOf(
        model, [&](const MeasuredSurface& body) { return TautLoop(body, 40.0 + 50.0 * static_cast<double>(k)); }, k);
    EXPECT_NEAR(loop.by_gradient, loop.by_differences, 3e-3) << k;
  }
}

TEST(TautTape, FailsOutsideTheRangeAndWhereItTouchesWhatWasNotSeenButSpansIt) {
  SurfaceModel model =
      InterpolatedBody([](double, double z) { return 95.0 + 5.0 * std::cos(kTwoPi * z / 100.0); }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_FALSE(TautTape(*body, {1.0, std::nan("")}, {2.0, 0.0}).has_value());
  EXPECT_FALSE(TautTape(*body, {std::numeric_limits<double>::infinity(), 0.0}, {2.0, 0.0}).has_value());
  EXPECT_FALSE(TautTape(*body, {1.0, 0.0}, {2.0, 201.0}).has_value());
  EXPECT_EQ(Length(TautTape(*body, {1.0, 0.0}, {1.0, 0.0})), 0.0);
  const auto unseen = [&](std::size_t low, std::size_t high) {  // rows of 7.5 mm from -100 mm
    for (std::size_t row = low; row <= high; ++row) {
      for (std::size_t column = 0; column < 36; ++column) {
        model.segments.front().knowledge.SetCell(column, row, Knowledge::kUnknown);
      }
    }
  };
  unseen(18, 20);  // 35 … 57.5 mm: in the groove
  const auto spanning = TautTape(*body, {2.0, 0.0}, {2.0, 100.0});
  EXPECT_NEAR(Length(spanning), 100.0, 1e-6);
  EXPECT_NEAR(spanning->knowledge.measured, 0.775, 0.03);
  EXPECT_EQ(spanning->knowledge.unknown, 0.0);
  unseen(12, 14);  // -10 … 12.5 mm: on the bulge
  const auto touching = TautTape(*body, {2.0, -45.0}, {2.0, 20.0});
  ASSERT_FALSE(touching.has_value());
  EXPECT_THAT(touching.error().Text(), testing::HasSubstr("% of it was not seen"));
}

TEST(TautLoop, OnACylinderIsTheHullOfItsSection) {
  // import numpy as np; from scipy.spatial import ConvexHull; t = np.linspace(0, 2*np.pi, 2000001)[:-1]
  // r = 100 + 20*np.cos(3*t); ConvexHull(np.c_[r*np.cos(t), r*np.sin(t)]).area
  const SurfaceModel lobed =
      InterpolatedBody([](double theta, double) { return 100.0 + 20.0 * std::cos(3.0 * theta); }, 360, Breaks());
  const SurfaceModel round = InterpolatedBody([](double, double) { return 90.0; }, 12, Breaks());
  const auto round_body = MeasuredSurface::FromModel(round);
  const auto loop = TautLoop(*MeasuredSurface::FromModel(lobed), 50.0);
  EXPECT_NEAR(Length(loop), 678.8852799029945, 6.7e-4);
  EXPECT_NEAR(Length(TautLoop(*round_body, 50.0)), kTwoPi * 90.0, 1e-6 * kTwoPi * 90.0);
  EXPECT_NEAR(Length(TautLoop(*round_body, -100.0)), kTwoPi * 90.0, 1e-6 * kTwoPi * 90.0);  // at the rim
}

TEST(TautLoop, OnAConeRunsStraightBetweenItsFourHoldsOnTheUnrolledSheet) {
  // tan(a) = 0.1: four chords of the sheet, each over a quarter turn, 8 mm above the level in the middle at most.
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 120.0 - 0.1 * z; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  const double sine = 0.1 / std::hypot(1.0, 0.1);
  const double expected = 4.0 * 2.0 * (115.0 / sine) * std::sin(0.25 * kPi * sine);
  const auto loop = TautLoop(*body, 50.0);
  EXPECT_NEAR(Length(loop), expected, 1e-6 * expected);
  for (const PathPoint& point : loop->path) {
    EXPECT_GE(point.position.z(), 50.0 - 1e-9);
    EXPECT_LE(point.position.z(), 50.0 + kLoopBand);
  }
}

TEST(TautLoop, IsNotLongerThanTheHullInThePlaneAndStaysInItsBand) {
  const SurfaceModel model = test::BumpyBody();
  const auto body = MeasuredSurface::FromModel(model);
  for (const double z : {5.0, 60.0, 110.0, 170.0, 230.0, 290.0}) {
    const auto loop = TautLoop(*body, z);
    EXPECT_LE(Length(loop), SectionAt(*body, z)->tape.value + 0.01);
    EXPECT_LT(DepthOfPath(body->surface(), loop->path), kTapeDepth);
    for (const PathPoint& point : loop->path) EXPECT_LE(std::abs(point.position.z() - z), kLoopBand + 1e-9);
  }
  EXPECT_FALSE(TautLoop(*body, 301.0).has_value());
  EXPECT_FALSE(TautLoop(*body, std::nan("")).has_value());
}

}  // namespace
}  // namespace annulus
