// On a cylinder whose coefficients have independent errors, the expected extra length has a closed form.

#include "modeling/measure/unresolved_length.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modeling/measure/section.h"
#include "modeling/measure/section_sampler.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

// Cubic B-splines with knots one apart: mean over the places of Σ B'² is ∫ B'² = 2/3, and at a knot Σ B² =
// (1 + 16 + 1)/36.
constexpr double kSlopeSquares = 2.0 / 3.0;
constexpr double kSquaresAtKnot = 0.5;

constexpr double kRadius = 100.0;  // mm
constexpr std::size_t kColumns = 90;
constexpr std::size_t kRows = 100;
constexpr double kHeight = 500.0;                        // mm
constexpr double kAround = kTwoPi * kRadius / kColumns;  // mm between knots
constexpr double kUp = kHeight / kRows;                  // mm between knots

/// The cylinder; every coefficient has an independent error of sd `sigma`, mm.
SurfaceModel Cylinder(double sigma) {
  SurfaceModel model =
      test::InterpolatedBody([](double, double) { return kRadius; }, kColumns, UniformBreakpoints(0.0, kHeight, kRows));
  SurfaceSegment& segment = model.segments.front();
  const Eigen::Index count = segment.surface.coefficients().size();
  Eigen::SparseMatrix<double> precision(count, count);
  precision.setIdentity();
  segment.normal_matrix = precision / (sigma * sigma);
  return model;
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

std::vector<PathPoint> Circle(const MeasuredSurface& body, double z, std::size_t count) {
  std::vector<PathPoint> path;
  for (const double theta : EvenDirections(count)) path.push_back(RadialPoint(body.surface(), {theta, z}));
  return path;
}

/// Heights on knots, so far apart that no coefficient counts twice.
std::vector<double> Heights() {
  std::vector<double> heights;
  for (std::size_t k = 4; k + 4 < kRows; k += 4) heights.push_back(kUp * static_cast<double>(k));
  return heights;
}

/// ½ ∫ E[(dδ/ds)²] ds around the cylinder at a knot's height, mm.
double ExpectedAround(double sigma) {
  return 0.5 * kTwoPi * kRadius * sigma * sigma * kSquaresAtKnot * kSlopeSquares / (kAround * kAround);
}

TEST(UnresolvedLength, AroundACylinderHasTheExpectationOfItsCoefficientsErrors) {
  // 23 heights of 8 deviations of 90 coefficients: the mean has an sd of about 2 %.
  const SurfaceModel model = Cylinder(0.5);
  const MeasuredSurface body = Measured(model);
  double sum = 0.0;
  for (const double z : Heights()) sum += UnresolvedLength(body, Circle(body, z, 1440), PathEnds::kClosed);
  const double expected = ExpectedAround(0.5);
  EXPECT_NEAR(sum / static_cast<double>(Heights().size()), expected, 0.06 * expected);
}

TEST(UnresolvedLength, OfAnUprightPathIsNone) {
  const SurfaceModel model = Cylinder(0.5);
  const MeasuredSurface body = Measured(model);
  std::vector<PathPoint> path;
  for (int k = 0; k <= 400; ++k) path.push_back(RadialPoint(body.surface(), {1.0, 100.0 + k}));
  // Rounding of the tangent only.
  EXPECT_NEAR(UnresolvedLength(body, path, PathEnds::kOpen), 0.0, 1e-20);
}

TEST(UnresolvedLength, GrowsWithTheSquareOfTheErrors) {
  const SurfaceModel small = Cylinder(0.1);
  const SurfaceModel large = Cylinder(0.3);
  const MeasuredSurface a = Measured(small);
  const MeasuredSurface b = Measured(large);
  EXPECT_NEAR(UnresolvedLength(b, Circle(b, 200.0, 720), PathEnds::kClosed),
              9.0 * UnresolvedLength(a, Circle(a, 200.0, 720), PathEnds::kClosed), 1e-9);
}

TEST(UnresolvedLength, OfOneEdgeIsHalfItsSquaredBendOverItsLengthByItsLevelShare) {
  // Both ends move outwards, across the edge; a slanting edge counts by the square of its level share. Moving along the
  // edge makes no length of second order. Of points that do not move, none.
  const SurfaceModel model = Cylinder(0.5);
  const MeasuredSurface body = Measured(model);
  PathPoint from = RadialPoint(body.surface(), {0.0, 200.0});
  PathPoint to = RadialPoint(body.surface(), {0.03, 203.0});
  from.by_radius = to.by_radius = Eigen::Vector3d::UnitX();
  from.position = {100.0, 0.0, 200.0};
  to.position = {100.0, 4.0, 203.0};  // 5 mm long, 4 of them level
  double expected = 0.0;
  for (const Eigen::VectorXd& deviation : body.Deviations()) {
    const SplineSurface moved(body.surface().theta_basis(), body.surface().z_basis(), deviation);
    const double bend = moved.Radius(0.03, 203.0) - moved.Radius(0.0, 200.0);
    expected += 0.8 * 0.8 * 0.5 * bend * bend / 5.0 / static_cast<double>(body.Deviations().size());
  }
  EXPECT_NEAR(UnresolvedLength(body, {from, to}, PathEnds::kOpen), expected, 1e-12);
  PathPoint outward = to;
  outward.position = from.position + 3.0 * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(UnresolvedLength(body, {from, outward}, PathEnds::kOpen), 0.0, 1e-12);
  from.by_radius.setZero();
  to.by_radius.setZero();
  EXPECT_EQ(UnresolvedLength(body, {from, to}, PathEnds::kOpen), 0.0);
}

TEST(UnresolvedLength, OfNoPathIsNone) {
  const SurfaceModel model = Cylinder(0.5);
  const MeasuredSurface body = Measured(model);
  const PathPoint point = RadialPoint(body.surface(), {1.0, 200.0});
  EXPECT_EQ(UnresolvedLength(body, {}, PathEnds::kClosed), 0.0);
  EXPECT_EQ(UnresolvedLength(body, {point}, PathEnds::kOpen), 0.0);
  EXPECT_EQ(UnresolvedLength(body, {point, point}, PathEnds::kOpen), 0.0);
}

TEST(UnresolvedLength, IsNoneWithoutANormalMatrix) {
  SurfaceModel model = Cylinder(0.5);
  model.segments.front().normal_matrix.resize(0, 0);
  const MeasuredSurface body = Measured(model);
  EXPECT_EQ(UnresolvedLength(body, Circle(body, 200.0, 720), PathEnds::kClosed), 0.0);
  EXPECT_EQ(UnresolvedHullLength(body, SectionSampler(body.surface(), EvenDirections(1440)), 200.0), 0.0);
  EXPECT_EQ(SectionAt(body, 200.0)->tape.unresolved, 0.0);
}

TEST(UnresolvedHullLength, IsThatOfTheSkinWhereTheSkinStaysConvex) {
  // Deviations of 1 µm bend a cylinder of 100 mm by far less than it is bent: its hull is its skin.
  constexpr double kSmall = 1e-3;
  const SurfaceModel model = Cylinder(kSmall);
  const MeasuredSurface body = Measured(model);
  double sum = 0.0;
  for (const double z : Heights())
    sum += UnresolvedHullLength(body, SectionSampler(body.surface(), EvenDirections(1440)), z);
  const double expected = ExpectedAround(kSmall);
  EXPECT_NEAR(sum / static_cast<double>(Heights().size()), expected, 0.06 * expected);
}

TEST(UnresolvedHullLength, IsNotNegativeAndNotMoreThanTheSkins) {
  // The hull of a mean is not longer than the mean of the hulls, and a tape spans the hollows that a skin follows.
  for (const double sigma : {0.05, 0.3, 1.0}) {
    const SurfaceModel model = Cylinder(sigma);
    const MeasuredSurface body = Measured(model);
    for (const double z : {0.0, 101.0, 333.3, 500.0}) {
      const double hull = UnresolvedHullLength(body, SectionSampler(body.surface(), EvenDirections(1440)), z);
      EXPECT_GE(hull, 0.0) << sigma << " " << z;
      EXPECT_LE(hull, 1.001 * UnresolvedLength(body, Circle(body, z, 1440), PathEnds::kClosed)) << sigma << " " << z;
    }
  }
}

TEST(WithUnresolved, AddsALengthToTheValueAndToWhatIsNotKnown) {
  const Estimate length = WithUnresolved({100.0, {}, 0.25}, 0.5);
  EXPECT_EQ(length.value, 100.5);
  EXPECT_EQ(length.unresolved, 0.75);
  EXPECT_EQ(WithUnresolved({100.0, {}}, -0.5).unresolved, 0.5);
}

}  // namespace
}  // namespace annulus
