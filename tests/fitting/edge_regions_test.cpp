#include "fitting/edge_regions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fitting/fit_surface.h"
#include "fitting/ray_weights.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

TEST(EdgeRegions, AreWhereASharpRidgeRuns) {
  // A ridge with a bend of 60 mm/rad·6 degrees... : |sin| at theta = 0 and pi/2 on a cylinder; noise 0.1 mm.
  test::ScanShape shape;
  shape.noise = 0.1;
  const auto tent = [](double theta, double) { return 150.0 - 25.0 * std::abs(std::sin(theta)); };
  const auto fit = FitSurface(test::SyntheticScan(tent, shape), {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  // Kinks of |sin| lie at 0 and 180 degrees, over all heights.
  ASSERT_EQ(fit->summary.edges.size(), 2U);
  for (const EdgeRegion& edge : fit->summary.edges) {
    const double middle = 0.5 * (edge.theta_from + edge.theta_to);
    EXPECT_LT(std::abs(std::sin(middle)), 0.05);
    EXPECT_GT(edge.z_max - edge.z_min, 0.8 * shape.z_max());
    EXPECT_LT(edge.theta_to - edge.theta_from, RadiansFromDegrees(20.0));
  }
}

TEST(EdgeRegions, AreNotInventedOnASmoothTrunk) {
  test::ScanShape shape;
  shape.noise = 0.5;
  const auto fit = FitSurface(test::SyntheticScan(test::SmoothTrunk, shape), {}, {});
  ASSERT_TRUE(fit.has_value());
  EXPECT_TRUE(fit->summary.edges.empty());
}

TEST(RayWeights, FollowHowARangeErrorMovesTheResidual) {
  // Against a difference: the sample's point moved by ±e along its ray, its radius less the surface's at its new place.
  const auto f = [](double theta, double z) { return 120.0 + 20.0 * std::cos(theta) + 0.8 * z; };
  SurfaceSample sample;
  sample.theta = 0.7;
  sample.z = 31.0;
  sample.radius = f(sample.theta, sample.z);
  const Eigen::Vector3d ray = Eigen::Vector3d(-0.8, -0.3, 0.35).normalized();
  sample.ray_direction = ray.cast<float>();
  const RadiusJet jet{sample.radius, -20.0 * std::sin(0.7), 0.8, -20.0 * std::cos(0.7), 0.0, 0.0};
  const auto residual = [&](double e) {
    const Eigen::Vector3d p = sample.Point() + e * ray;
    return std::hypot(p.x(), p.y()) - f(std::atan2(p.y(), p.x()), p.z());
  };
  constexpr double kStep = 1e-4;
  EXPECT_NEAR(ResidualPerRange(sample, jet), (residual(kStep) - residual(-kStep)) / (2.0 * kStep), 1e-6);
}

TEST(RayWeights, LetObliqueRaysCountLessWhereTheyMoveTheRadiusMore) {
  // A cone r = 100 + 2z seen by every other level under 60 degrees from below: noise 0.3 mm along those rays moves the
  // radius by 0.3·(cos 60° + 2 sin 60°) = 0.67 mm. With right weights the error falls below that of equal ones.
  test::ScanShape shape;
  shape.levels = 40;
  const auto cone = [](double, double z) { return 100.0 + 2.0 * z; };
  std::mt19937_64 random(3);
  const double tilt = RadiansFromDegrees(60.0);
  std::vector<SurfaceSample> samples = test::SyntheticScan(cone, shape);
  for (SurfaceSample& s : samples) {
    const bool oblique = s.level % 2 == 0;
    const double noise = 0.3 * test::Normal(random);
    s.radius += oblique ? -noise * (std::cos(tilt) + 2.0 * std::sin(tilt)) : -noise;
    const Eigen::Vector3d inwards = -PointFromCylindrical(s.theta, 1.0, 0.0);
    s.ray_direction =
        (oblique ? Eigen::Vector3d(std::cos(tilt) * inwards + std::sin(tilt) * Eigen::Vector3d::UnitZ()) : inwards)
            .cast<float>();
  }
  const auto rms = [&](const std::vector<SurfaceSample>& given) {
    const auto fit = FitSurface(given, {}, {});
    EXPECT_TRUE(fit.has_value());
    double squares = 0.0;
    for (const SurfaceSample& s : given) {
      const double error = fit->model.main().surface.Radius(s.theta, s.z) - cone(s.theta, s.z);
      squares += error * error;
    }
    return std::sqrt(squares / static_cast<double>(given.size()));
  };
  const double with_rays = rms(samples);
  for (SurfaceSample& s : samples) s.ray_direction.setZero();
  EXPECT_LT(with_rays, 0.97 * rms(samples));
}

}  // namespace
}  // namespace annulus
