#include "modeling/measure/curvature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

SurfaceCurvature CurvatureOf(const SurfaceModel& model, const SurfacePlace& place) {
  const auto curvature = CurvatureAt(Measured(model), place);
  if (!curvature) throw std::runtime_error(curvature.error().Text());
  return *curvature;
}

// The second derivative of an interpolating cubic spline is off by O(h²): closed forms hold to about 4e-5 of the value.

Eigen::Vector3d Tangential(double theta) { return {-std::sin(theta), std::cos(theta), 0.0}; }

TEST(Curvature, OfACylinderIsOneOverItsRadiusAround) {
  const SurfaceModel model =
      InterpolatedBody([](double, double) { return 80.0; }, 36, UniformBreakpoints(0.0, 100.0, 10));
  const SurfaceCurvature c = CurvatureOf(model, {1.3, 44.0});
  EXPECT_NEAR(c.largest, 1.0 / 80.0, 1e-12);
  EXPECT_NEAR(c.smallest, 0.0, 1e-12);
  EXPECT_NEAR(c.mean.value, 0.5 / 80.0, 1e-12);
  EXPECT_NEAR(c.gaussian.value, 0.0, 1e-14);
  EXPECT_LT((c.largest_direction - Tangential(1.3)).norm(), 1e-9);
  EXPECT_LT((c.smallest_direction - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(Curvature, OfAConeIsItsNormalRadiusAround) {
  // r = 150 - z/2: 1/(r·√(1 + 1/4)) around, 0 along the generator.
  const SurfaceModel model =
      InterpolatedBody([](double, double z) { return 150.0 - 0.5 * z; }, 36, UniformBreakpoints(0.0, 100.0, 10));
  const SurfaceCurvature c = CurvatureOf(model, {4.0, 60.0});
  EXPECT_NEAR(c.largest, 1.0 / (120.0 * std::sqrt(1.25)), 1e-12);
  EXPECT_NEAR(c.smallest, 0.0, 1e-12);
  const Eigen::Vector3d generator = Eigen::Vector3d(-0.5 * std::cos(4.0), -0.5 * std::sin(4.0), 1.0) / std::sqrt(1.25);
  EXPECT_LT((c.smallest_direction - generator).norm(), 1e-9);
}

TEST(Curvature, OfASphereIsTheSameInAllDirections) {
  const double radius = 120.0;
  const SurfaceModel model = InterpolatedBody([&](double, double z) { return std::sqrt(radius * radius - z * z); }, 72,
                                              UniformBreakpoints(-90.0, 90.0, 360));
  const SurfaceCurvature c = CurvatureOf(model, {2.0, 40.0});
  EXPECT_NEAR(c.largest, 1.0 / radius, 1e-6);
  EXPECT_NEAR(c.smallest, 1.0 / radius, 1e-6);
  EXPECT_NEAR(c.mean.value, 1.0 / radius, 1e-6);
  EXPECT_NEAR(c.gaussian.value, 1.0 / (radius * radius), 1e-8);
  EXPECT_NEAR(c.largest_direction.dot(c.smallest_direction), 0.0, 1e-12);
  EXPECT_NEAR(c.largest_direction.norm(), 1.0, 1e-12);
}

TEST(Curvature, OfATorusOutsideIsThatOfItsTubeAndOfItsRing) {
  // Tube a = 60 about a ring R = 150: 1/a along the tube's circle, cos(phi)/(R + a cos(phi)) around, z = a sin(phi).
  const double a = 60.0;
  const double ring = 150.0;
  const SurfaceModel model = InterpolatedBody([&](double, double z) { return ring + std::sqrt(a * a - z * z); }, 36,
                                              UniformBreakpoints(-48.0, 48.0, 192));
  for (const double z : {-40.0, 0.0, 25.0}) {
    const double cosine = std::sqrt(1.0 - z * z / (a * a));
    const SurfaceCurvature c = CurvatureOf(model, {0.5, z});
    EXPECT_NEAR(c.largest, 1.0 / a, 5e-6);
    EXPECT_NEAR(c.smallest, cosine / (ring + a * cosine), 1e-8);
    EXPECT_LT((c.smallest_direction - Tangential(0.5)).norm(), 1e-6);
  }
}

TEST(Curvature, OfAnEllipsoidIsItsClosedForm) {
  // x²/a² + y²/b² + z²/c² = 1 with h = x²/a⁴ + y²/b⁴ + z²/c⁴: K = 1/(a²b²c²h²),
  // H = (a² + b² + c² - |P|²)/(2a²b²c²h^{3/2}).
  const double a = 150.0;
  const double b = 110.0;
  const double c = 200.0;
  const SurfaceModel model = InterpolatedBody(
      [&](double theta, double z) {
        return std::sqrt(1.0 - z * z / (c * c)) / std::hypot(std::cos(theta) / a, std::sin(theta) / b);
      },
      360, UniformBreakpoints(-160.0, 160.0, 320));
  const MeasuredSurface body = Measured(model);
  for (const SurfacePlace place : {SurfacePlace{0.4, 0.0}, SurfacePlace{1.3, 90.0}, SurfacePlace{5.0, -130.0}}) {
    const Eigen::Vector3d p = body.Point(place.theta, place.z);
    const Eigen::Array3d axes(a, b, c);
    const double h = (p.array().square() / axes.pow(4)).sum();
    const double product = axes.square().prod();
    const auto curvature = CurvatureAt(body, place);
    ASSERT_TRUE(curvature);
    const double mean = (axes.square().sum() - p.squaredNorm()) / (2.0 * product * std::pow(h, 1.5));
    const double gaussian = 1.0 / (product * h * h);
    EXPECT_NEAR(curvature->mean.value, mean, 4e-5 * mean);
    EXPECT_NEAR(curvature->gaussian.value, gaussian, 8e-5 * gaussian);
    EXPECT_NEAR(0.5 * (curvature->largest + curvature->smallest), mean, 4e-5 * mean);
    EXPECT_NEAR(curvature->largest * curvature->smallest, gaussian, 8e-5 * gaussian);
    EXPECT_GT(curvature->largest_direction.z(), 0.0);
  }
}

TEST(Curvature, OfACatenoidIsZeroInTheMeanAndNegativeInTheProduct) {
  // r = a cosh(z/a): H = 0, K = -1/(a² cosh⁴(z/a)); a waist bends inward along the height.
  const double a = 90.0;
  const SurfaceModel model = InterpolatedBody([&](double, double z) { return a * std::cosh(z / a); }, 36,
                                              UniformBreakpoints(-80.0, 80.0, 160));
  const SurfaceCurvature c = CurvatureOf(model, {3.0, 30.0});
  const double gaussian = -1.0 / (a * a * std::pow(std::cosh(30.0 / a), 4));
  EXPECT_NEAR(c.mean.value, 0.0, 4e-7);
  EXPECT_NEAR(c.gaussian.value, gaussian, 4e-5 * std::abs(gaussian));
  EXPECT_NEAR(c.smallest, -std::sqrt(-gaussian), 4e-7);
  EXPECT_GT(c.smallest_direction.z(), 0.5);
}

TEST(Curvature, FollowsTheSurfaceAsItsGradientsSay) {
  // A cylinder that grows by 1 everywhere: d(1/2r)/dr = -1/(2r²); a wavy body against central differences.
  const SurfaceModel cylinder =
      InterpolatedBody([](double, double) { return 80.0; }, 36, UniformBreakpoints(0.0, 100.0, 10));
  EXPECT_NEAR(CurvatureOf(cylinder, {1.0, 50.0}).mean.gradient.sum(), -0.5 / (80.0 * 80.0), 1e-12);
  const SurfaceModel wavy =
      InterpolatedBody([](double theta, double z) { return 100.0 + 12.0 * std::cos(2.0 * theta + z / 30.0); }, 36,
                       UniformBreakpoints(0.0, 100.0, 20));
  const SurfacePlace place{1.1, 47.0};
  const SurfaceCurvature whole = CurvatureOf(wavy, place);
  EXPECT_EQ(whole.mean.gradient.nonZeros(), 16);
  for (Gradient::InnerIterator entry(whole.mean.gradient); entry; ++entry) {
    const auto moved = [&](double by) {
      SurfaceModel other = wavy;
      SplineSurface& surface = other.segments.front().surface;
      Eigen::VectorXd c = surface.coefficients();
      c[entry.index()] += by;
      surface = SplineSurface(surface.theta_basis(), surface.z_basis(), c);
      return CurvatureOf(other, place);
    };
    const SurfaceCurvature more = moved(1e-3);
    const SurfaceCurvature less = moved(-1e-3);
    EXPECT_NEAR(entry.value(), (more.mean.value - less.mean.value) / 2e-3, 1e-9);
    EXPECT_NEAR(whole.gaussian.gradient.coeff(entry.index()), (more.gaussian.value - less.gaussian.value) / 2e-3,
                1e-10);
  }
}

TEST(Curvature, IsRefusedWhereThereIsNoSeenSurface) {
  SurfaceModel model =
      InterpolatedBody([](double, double z) { return 100.0 - z; }, 36, UniformBreakpoints(0.0, 120.0, 12));
  model.segments.front().knowledge.SetCell(0, 0, Knowledge::kUnknown);
  const MeasuredSurface body = Measured(model);
  const auto seen = [&](const SurfacePlace& place) {
    const auto curvature = CurvatureAt(body, place);
    return curvature ? std::string("measured") : curvature.error().Text();
  };
  EXPECT_THAT(seen({0.0, 130.0}), HasSubstr("outside the scanned range"));
  EXPECT_THAT(seen({0.0, 1.0}), HasSubstr("not seen"));
  EXPECT_THAT(seen({1.0, 110.0}), HasSubstr("axis"));
  EXPECT_THAT(seen({std::numeric_limits<double>::infinity(), 50.0}), HasSubstr("theta"));
  EXPECT_THAT(seen({1.0, std::numeric_limits<double>::quiet_NaN()}), HasSubstr("outside the scanned range"));
}

}  // namespace
}  // namespace annulus
