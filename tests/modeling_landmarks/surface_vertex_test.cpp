#include "modeling/landmarks/surface_vertex.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "base/units.h"
#include "fitting/bspline_basis.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kFront = kPi / 2.0;

SplineSurface Body(const test::RadiusFunction& radius, std::size_t columns = 180, std::size_t intervals = 100) {
  return test::InterpolatedBody(radius, columns, UniformBreakpoints(0.0, 200.0, intervals)).segments[0].surface;
}

/// A bump that is not symmetric in z, on a slanted cylinder that is turned by some degrees: nothing special anywhere.
double LopsidedBump(double theta, double z) {
  const double across = AngleDifference(theta, kFront + 0.05) / 0.12;
  const double up = (z - 104.0) / (z > 104.0 ? 22.0 : 17.0);
  return 90.0 + 3.0 * std::cos(theta - 1.0) + 0.04 * z +
         18.0 * std::exp(-0.5 * (across * across + up * up + 0.4 * across * up));
}

SplineSurface WithCoefficient(const SplineSurface& surface, Eigen::Index index, double change) {
  Eigen::VectorXd c = surface.coefficients();
  c[index] += change;
  return {surface.theta_basis(), surface.z_basis(), c};
}

/// The field at places of its own, to be told from the code's.
TEST(SurfaceField, IsTheRadiusOrTheDistanceAlongADirectionOrAboveAChord) {
  const SplineSurface surface = Body(LopsidedBump);
  const SurfacePlace place{kFront + 0.1, 99.0};
  EXPECT_NEAR(SurfaceField::Radius().At(surface, place), surface.Radius(place.theta, place.z), 1e-12);
  const Vector3d direction(0.3, 2.0, -0.5);
  const auto along = [&](double theta, double z) { return surface.Point(theta, z).dot(direction.normalized()); };
  EXPECT_NEAR(SurfaceField::Along(direction).At(surface, place), along(place.theta, place.z), 1e-12);
  const double chord = 0.5 * (along(place.theta - 0.1, place.z - 20.0) + along(place.theta + 0.1, place.z + 20.0));
  EXPECT_NEAR(SurfaceField::Along(direction).OverChord(0.1, 20.0).At(surface, place),
              along(place.theta, place.z) - chord, 1e-12);
}

TEST(SurfaceVertex, OfAnEllipsoidAlongItsAxisIsItsPole) {
  // Semi-axes 80 (x), 100 (y), 120 (z) about z = 100: the foremost point is (0, 100, 100), where y falls by
  // x²·100/(2·80²) across and by z²·100/(2·120²) upwards.
  const SplineSurface surface = Body([](double theta, double z) {
    const double rest = 1.0 - (z - 100.0) * (z - 100.0) / (120.0 * 120.0);
    const double x = std::cos(theta) / 80.0;
    const double y = std::sin(theta) / 100.0;
    return std::sqrt(rest / (x * x + y * y));
  });
  const VertexQuery query{.field = SurfaceField::Along({0, 1, 0}), .half_across = 10.0, .half_up = 12.0};
  const auto vertex = FindVertex(surface, {kFront + 0.08, 91.0}, query);
  ASSERT_TRUE(vertex);
  EXPECT_NEAR(vertex->theta.value, kFront, 1e-7);
  EXPECT_NEAR(vertex->z.value, 100.0, 1e-5);
  EXPECT_NEAR(vertex->height, 100.0, 0.01);
  EXPECT_NEAR(vertex->rise_across, -100.0 * 100.0 / (2.0 * 80.0 * 80.0), 0.03);
  EXPECT_NEAR(vertex->rise_up, -144.0 * 100.0 / (2.0 * 120.0 * 120.0), 0.03);
  EXPECT_LT(vertex->residual, 0.01);
  EXPECT_GT(vertex->confidence, 0.4);
  EXPECT_LT(vertex->confidence, 0.7);  // a shallow cap of half a millimetre
}

TEST(SurfaceVertex, OfACubicProfileIsWhereItsLeastSquaresParaboloidIs) {
  // r = 100 − b s² + d s³ up, s = z − 90, and a cosine across. With weights 1 − u² the least-squares slope about s is
  // −2 b s + 3 d s² + (3/7) d h²: its smaller root is the vertex.
  constexpr double kB = 0.01;
  constexpr double kD = 1e-4;
  constexpr double kHalf = 16.0;
  const SplineSurface surface = Body([](double theta, double z) {
    const double s = z - 90.0;
    return 100.0 - kB * s * s + kD * s * s * s + 5.0 * std::cos(3.0 * (theta - 1.2));
  });
  const VertexQuery query{.field = SurfaceField::Radius(), .half_across = 12.0, .half_up = kHalf};
  const auto vertex = FindVertex(surface, {1.15, 95.0}, query);
  ASSERT_TRUE(vertex);
  const double c = 3.0 / 7.0 * kD * kHalf * kHalf;
  const double s = (2.0 * kB - std::sqrt(4.0 * kB * kB - 12.0 * kD * c)) / (6.0 * kD);
  EXPECT_NEAR(vertex->z.value, 90.0 + s, 0.02);
  EXPECT_NEAR(vertex->theta.value, 1.2, 1e-5);
}

/// An empty gradient counts as zero.
Eigen::VectorXd Dense(const Gradient& gradient, const SplineSurface& surface) {
  if (gradient.size() == 0) return Eigen::VectorXd::Zero(surface.coefficients().size());
  return gradient;
}

void ExpectGradient(const SplineSurface& surface, const SurfacePlace& start, const VertexQuery& query) {
  const auto vertex = FindVertex(surface, start, query);
  ASSERT_TRUE(vertex);
  const Eigen::VectorXd by_theta = Dense(vertex->theta.gradient, surface);
  const Eigen::VectorXd by_z = Dense(vertex->z.gradient, surface);
  constexpr double kStep = 1e-3;
  int moved = 0;
  for (Eigen::Index k = 0; k < by_z.size(); k += 7) {
    if (by_theta[k] == 0.0 && by_z[k] == 0.0) continue;
    const auto more = FindVertex(WithCoefficient(surface, k, kStep), start, query);
    const auto less = FindVertex(WithCoefficient(surface, k, -kStep), start, query);
    ASSERT_TRUE(more && less);
    EXPECT_NEAR(by_theta[k], (more->theta.value - less->theta.value) / (2.0 * kStep), 1e-7) << k;
    EXPECT_NEAR(by_z[k], (more->z.value - less->z.value) / (2.0 * kStep), 1e-5) << k;
    ++moved;
  }
  EXPECT_GT(moved, 5);
}

TEST(SurfaceVertex, CarriesTheGradientsThatFiniteDifferencesGive) {
  const SplineSurface surface = Body(LopsidedBump, 90, 50);
  const SurfacePlace start{kFront, 100.0};
  const VertexQuery query{.field = SurfaceField::Along({0.2, 1.0, 0.1}), .half_across = 9.0, .half_up = 11.0};
  ExpectGradient(surface, start, query);
  VertexQuery radius = query;
  radius.field = SurfaceField::Radius();
  ExpectGradient(surface, start, radius);
  VertexQuery chord = query;
  chord.field = query.field.OverChord(0.0, 20.0);
  ExpectGradient(surface, start, chord);
  VertexQuery up = query;
  up.freedom = VertexFreedom::kUp;
  ExpectGradient(surface, start, up);
  VertexQuery across = query;
  across.freedom = VertexFreedom::kAcross;
  ExpectGradient(surface, start, across);
}

TEST(SurfaceVertex, AlongAGivenLineFollowsThatLine) {
  const SplineSurface surface = Body(LopsidedBump);
  const VertexQuery query{
      .field = SurfaceField::Along({0, 1, 0}), .freedom = VertexFreedom::kUp, .half_across = 9.0, .half_up = 11.0};
  // theta follows a made-up unknown: the first coefficient, which the window does not touch.
  Estimate theta{kFront - 0.05, Gradient(surface.coefficients().size())};
  theta.gradient.insert(0) = 1.0;
  const auto vertex = FindVertexAlong(surface, theta, {100.0, {}}, query);
  ASSERT_TRUE(vertex);
  constexpr double kStep = 1e-4;
  const auto more = FindVertex(surface, {theta.value + kStep, 100.0}, query);
  const auto less = FindVertex(surface, {theta.value - kStep, 100.0}, query);
  ASSERT_TRUE(more && less);
  EXPECT_NEAR(vertex->z.gradient.coeff(0), (more->z.value - less->z.value) / (2.0 * kStep), 1e-4);
  EXPECT_NE(vertex->z.gradient.coeff(0), 0.0);
  EXPECT_EQ(vertex->theta.gradient.coeff(0), 1.0);
}

TEST(SurfaceVertex, HardlyMovesWithNoiseAndMovesAsItsGradientSays) {
  const SplineSurface surface = Body(LopsidedBump);
  const VertexQuery query{.field = SurfaceField::Along({0, 1, 0}), .half_across = 12.0, .half_up = 12.0};
  const auto clean = FindVertex(surface, {kFront, 100.0}, query);
  ASSERT_TRUE(clean);
  std::mt19937_64 engine(20);
  std::normal_distribution<double> noise(0.0, 0.3);
  const Eigen::VectorXd by_z = clean->z.gradient;
  const double predicted = 0.3 * by_z.norm();
  double squares = 0.0;
  constexpr int kRuns = 40;
  for (int run = 0; run < kRuns; ++run) {
    Eigen::VectorXd c = surface.coefficients();
    for (double& value : c) value += noise(engine);
    const auto vertex = FindVertex({surface.theta_basis(), surface.z_basis(), c}, {kFront, 100.0}, query);
    ASSERT_TRUE(vertex);
    squares += std::pow(vertex->z.value - clean->z.value, 2);
  }
  const double sd = std::sqrt(squares / kRuns);
  EXPECT_LT(sd, 0.3);
  EXPECT_NEAR(sd, predicted, 0.35 * predicted);  // the sd of 40 draws is known to 11 %
}

TEST(SurfaceVertex, TellsASaddleFromASummit) {
  // A ridge at the front that dips at z = 100: the root of a nose.
  const SplineSurface surface = Body([](double theta, double z) {
    const double across = AngleDifference(theta, kFront) / 0.1;
    return 80.0 + 15.0 * std::exp(-0.5 * across * across) - 4.0 * std::cos((z - 100.0) / 20.0);
  });
  VertexQuery query{.field = SurfaceField::Along({0, 1, 0}), .shape = VertexShape::kRidgeHollow};
  const auto saddle = FindVertex(surface, {kFront + 0.03, 107.0}, query);
  ASSERT_TRUE(saddle);
  EXPECT_NEAR(saddle->theta.value, kFront, 1e-6);
  EXPECT_NEAR(saddle->z.value, 100.0, 1e-4);
  EXPECT_LT(saddle->rise_across, 0.0);
  EXPECT_GT(saddle->rise_up, 0.0);
  query.shape = VertexShape::kHollow;
  EXPECT_FALSE(FindVertex(surface, {kFront, 100.0}, query));
  query.shape = VertexShape::kSummit;  // climbs to the crest above or below, farther than three windows
  EXPECT_FALSE(FindVertex(surface, {kFront, 101.0}, query));
}

TEST(SurfaceVertex, IsNotInventedWhereThereIsNone) {
  const SplineSurface cylinder = Body([](double, double) { return 100.0; });
  VertexQuery query{.field = SurfaceField::Radius()};
  EXPECT_FALSE(FindVertex(cylinder, {1.0, 100.0}, query));
  const SplineSurface cone = Body([](double, double z) { return 100.0 + 0.3 * z; });
  EXPECT_FALSE(FindVertex(cone, {1.0, 100.0}, query));
  const SplineSurface bump = Body(LopsidedBump);
  EXPECT_FALSE(FindVertex(bump, {kFront, 300.0}, query));
  EXPECT_FALSE(FindVertex(bump, {kFront, 1.0}, query));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FindVertex(bump, {nan, 100.0}, query));
  EXPECT_FALSE(FindVertex(bump, {kFront, nan}, query));
  query.half_up = 0.0;
  EXPECT_FALSE(FindVertex(bump, {kFront, 100.0}, query));
  query.half_up = nan;
  EXPECT_FALSE(FindVertex(bump, {kFront, 100.0}, query));
}

}  // namespace
}  // namespace annulus
