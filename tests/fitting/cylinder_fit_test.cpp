#include "fitting/cylinder_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "base/ring_calibration.h"
#include "base/units.h"

namespace annulus {
namespace {

/// A cylinder of radius R with its axis through `foot` along `axis`, in closed form of its own: the nearest root of
/// |(p − foot) × axis| = R along the beam.
double TrueDistance(const Ray& ray, const Eigen::Vector3d& foot, const Eigen::Vector3d& axis, double radius) {
  const Eigen::Vector3d w = (ray.origin - foot).cross(axis);
  const Eigen::Vector3d v = ray.direction.cross(axis);
  const double half = w.dot(v);
  const double root = half * half - v.squaredNorm() * (w.squaredNorm() - radius * radius);
  return (-half - std::sqrt(root)) / v.squaredNorm();
}

struct Placed {
  Eigen::Vector3d foot{0.0, 0.0, 0.0};
  double slope_x = 0.0;
  double slope_y = 0.0;
  double radius = 150.0;
};

std::vector<CylinderReturn> Scanned(const Placed& placed, double noise, std::uint64_t seed) {
  const RingCalibration ring = RingCalibration::Ideal(600.0);
  const Eigen::Vector3d axis = Eigen::Vector3d(placed.slope_x, placed.slope_y, 1.0).normalized();
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian;
  std::vector<CylinderReturn> returns;
  for (double z = 100.0; z < 900.0; z += 20.0) {
    for (std::size_t sensor = 0; sensor < ring.sensors.size(); ++sensor) {
      const Ray ray = ring.RayOf(sensor, z);
      const double distance = TrueDistance(ray, placed.foot, axis, placed.radius);
      if (std::isfinite(distance)) returns.push_back({ray, distance + noise * gaussian(random)});
    }
  }
  return returns;
}

TEST(CylinderFit, FindsAnExactCylinderToTheLastMicrometre) {
  for (const Placed& placed :
       {Placed{}, Placed{{60.0, -90.0, 0.0}, 0.12, -0.08, 75.0}, Placed{{-110.0, 20.0, 300.0}, -0.17, 0.02, 150.0}}) {
    const auto fit = FitCylinder(Scanned(placed, 0.0, 1));
    ASSERT_TRUE(fit) << fit.error().Text();
    EXPECT_TRUE(fit->converged);
    EXPECT_NEAR(fit->pose.radius_mm, placed.radius, 1e-6);
    const Eigen::Vector2d foot = fit->pose.AxisAt(placed.foot.z());
    EXPECT_NEAR(foot.x(), placed.foot.x(), 1e-5);
    EXPECT_NEAR(foot.y(), placed.foot.y(), 1e-5);
    EXPECT_NEAR(fit->pose.slope_x, placed.slope_x, 1e-8);
    EXPECT_NEAR(fit->pose.slope_y, placed.slope_y, 1e-8);
    EXPECT_NEAR(fit->pose.tilt(), std::atan(std::hypot(placed.slope_x, placed.slope_y)), 1e-8);
  }
}

TEST(CylinderFit, CoversTheTruthAsItsCovarianceSays) {
  const Placed placed{{40.0, -70.0, 500.0}, 0.1, 0.05, 150.0};
  int inside = 0;
  double chi_square = 0.0;
  constexpr int kSeeds = 60;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto fit = FitCylinder(Scanned(placed, 0.5, static_cast<std::uint64_t>(seed)));
    ASSERT_TRUE(fit) << fit.error().Text();
    EXPECT_NEAR(fit->sigma_mm, 0.5, 0.03);
    Eigen::Matrix<double, 5, 1> error;
    const Eigen::Vector2d at = fit->pose.AxisAt(placed.foot.z());
    error << at.x() - placed.foot.x(), at.y() - placed.foot.y(), fit->pose.slope_x - placed.slope_x,
        fit->pose.slope_y - placed.slope_y, fit->pose.radius_mm - placed.radius;
    inside += std::abs(error(4)) <= 1.96 * std::sqrt(fit->covariance(4, 4)) ? 1 : 0;
    Eigen::Matrix<double, 5, 5> moved = Eigen::Matrix<double, 5, 5>::Identity();
    moved(0, 2) = moved(1, 3) = placed.foot.z() - fit->pose.z_reference_mm;
    const Eigen::Matrix<double, 5, 5> covariance = moved * fit->covariance * moved.transpose();
    chi_square += error.dot(covariance.ldlt().solve(error));
  }
  EXPECT_GE(inside, 52);
  // Chi-square of 300 degrees: 300 with sd 24.5; Tukey's biweight at 4.685 adds a twentieth.
  EXPECT_NEAR(chi_square / (5 * kSeeds), 1.05, 0.25);
}

TEST(CylinderFit, SpikesWrongSensorsAndAStandBesideItCountNothing) {
  const Placed placed{{30.0, 40.0, 500.0}, 0.02, -0.03, 150.0};
  std::vector<CylinderReturn> returns = Scanned(placed, 0.5, 7);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> spike(-200.0, 200.0);
  for (std::size_t k = 0; k < returns.size(); ++k) {
    if (k % 50 == 0) returns[k].distance_mm += spike(random);
    if (k % 180 == 17 || k % 180 == 18) returns[k].distance_mm += 4.0;  // two sensors that are wrong
    if (k % 180 >= 40 && k % 180 < 60) returns[k].distance_mm = 300.0 + spike(random) / 10.0;  // something before it
  }
  const auto fit = FitCylinder(returns);
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_NEAR(fit->pose.radius_mm, placed.radius, 0.05);
  const Eigen::Vector2d at = fit->pose.AxisAt(placed.foot.z());
  EXPECT_NEAR(at.x(), placed.foot.x(), 0.05);
  EXPECT_NEAR(at.y(), placed.foot.y(), 0.05);
  EXPECT_NEAR(fit->residuals_mm[17], 4.0, 2.0);
}

TEST(CylinderFit, KeepsAKnownRadius) {
  CylinderFitOptions options;
  options.known_radius_mm = 150.3;
  const auto fit = FitCylinder(Scanned({}, 0.0, 1), options);
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_EQ(fit->pose.radius_mm, 150.3);
  EXPECT_EQ(fit->covariance(4, 4), 0.0);
  // Every beam of a centred ring is then longer than predicted by the same 0.3 mm.
  for (const double residual : fit->residuals_mm) EXPECT_NEAR(residual, 0.3, 1e-6);
}

TEST(CylinderFit, RefusesWhatDoesNotDetermineACylinder) {
  const std::vector<CylinderReturn> all = Scanned({}, 0.1, 1);
  EXPECT_FALSE(FitCylinder({}));
  EXPECT_FALSE(FitCylinder({all.begin(), all.begin() + 10}));
  EXPECT_FALSE(FitCylinder({all.begin(), all.begin() + 180})) << "one height";
  EXPECT_FALSE(FitCylinder({all.begin(), all.begin() + 40})) << "one side";
  std::vector<CylinderReturn> broken = all;
  broken[5].distance_mm = std::nan("");
  EXPECT_FALSE(FitCylinder(broken));
}

}  // namespace
}  // namespace annulus
