#include "fitting/spline_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "base/ensure.h"

namespace annulus {
namespace {

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

SplineSurface RandomSurface(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const PeriodicCubicBasis theta(9);
  const ClampedCubicBasis z({-40.0, -10.0, 5.0, 60.0});
  Eigen::VectorXd c(static_cast<Eigen::Index>(theta.count() * z.count()));
  for (double& value : c) value = Uniform(random, 80.0, 120.0);
  return {theta, z, c};
}

/// r = a + b·z: coefficients a + b·(Greville abscissa), the same around.
SplineSurface Cone(double at_zero, double slope) {
  const PeriodicCubicBasis theta(8);
  const ClampedCubicBasis z({0.0, 30.0, 90.0, 100.0});
  const std::array<double, 6> greville{0.0, 10.0, 40.0, 220.0 / 3.0, 290.0 / 3.0, 100.0};
  Eigen::VectorXd c(48);
  for (Eigen::Index j = 0; j < 6; ++j) {
    for (Eigen::Index i = 0; i < 8; ++i) c[j * 8 + i] = at_zero + slope * greville[static_cast<std::size_t>(j)];
  }
  return {theta, z, c};
}

TEST(SplineSurface, OfEqualCoefficientsIsACylinder) {
  const SplineSurface cylinder(PeriodicCubicBasis(7), ClampedCubicBasis({0.0, 1.0}),
                               Eigen::VectorXd::Constant(28, 90.0));
  std::mt19937_64 random(1);
  for (int k = 0; k < 200; ++k) {
    const double theta = Uniform(random, -10.0, 10.0);
    const double z = Uniform(random, 0.0, 1.0);
    EXPECT_NEAR(cylinder.Radius(theta, z), 90.0, 1e-12);
    EXPECT_TRUE(cylinder.Normal(theta, z).isApprox(PointFromCylindrical(theta, 1.0, 0.0), 1e-12));
    EXPECT_TRUE(cylinder.Point(theta, z).isApprox(PointFromCylindrical(theta, 90.0, z), 1e-12));
  }
}

TEST(SplineSurface, OnAConeHasTheConesNormal) {
  // r = 50 + 0.4 z: the outward normal is (cos θ, sin θ, -0.4)/sqrt(1 + 0.16).
  const SplineSurface cone = Cone(50.0, 0.4);
  for (const double z : {0.0, 12.0, 30.0, 77.0, 100.0}) {
    EXPECT_NEAR(cone.Radius(1.0, z), 50.0 + 0.4 * z, 1e-11);
    const Eigen::Vector3d expected = PointFromCylindrical(1.0, 1.0, -0.4) / std::sqrt(1.16);
    EXPECT_LT((cone.Normal(1.0, z) - expected).norm(), 1e-12);
  }
}

TEST(SplineSurface, JetHasTheDerivativesThatDifferencesShow) {
  const SplineSurface surface = RandomSurface(2);
  std::mt19937_64 random(3);
  const double h = 1e-4;
  for (int k = 0; k < 200; ++k) {
    const double t = Uniform(random, 0.0, kTwoPi);
    const double z = Uniform(random, surface.z_min() + 1.0, surface.z_max() - 1.0);
    const RadiusJet jet = surface.Jet(t, z);
    const auto r = [&](double dt, double dz) { return surface.Radius(t + dt, z + dz); };
    EXPECT_NEAR(jet.r, r(0, 0), 1e-11);
    EXPECT_NEAR(jet.r_theta, (r(h, 0) - r(-h, 0)) / (2 * h), 1e-4);
    EXPECT_NEAR(jet.r_z, (r(0, h) - r(0, -h)) / (2 * h), 1e-6);
    const RadiusJet left = surface.Jet(t - h, z);
    const RadiusJet right = surface.Jet(t + h, z);
    const RadiusJet below = surface.Jet(t, z - h);
    const RadiusJet above = surface.Jet(t, z + h);
    EXPECT_NEAR(jet.r_theta_theta, (right.r_theta - left.r_theta) / (2 * h), 0.05);
    EXPECT_NEAR(jet.r_theta_z, (right.r_z - left.r_z) / (2 * h), 1e-4);
    EXPECT_NEAR(jet.r_theta_z, (above.r_theta - below.r_theta) / (2 * h), 1e-4);
    EXPECT_NEAR(jet.r_z_z, (above.r_z - below.r_z) / (2 * h), 1e-4);
  }
}

TEST(SplineSurface, RowTimesCoefficientsIsTheRadiusAndItsSlopes) {
  const SplineSurface surface = RandomSurface(4);
  std::mt19937_64 random(5);
  for (int k = 0; k < 200; ++k) {
    const double t = Uniform(random, -7.0, 7.0);
    const double z = Uniform(random, surface.z_min(), surface.z_max());
    const RadiusRow row = surface.Row(t, z);
    double r = 0.0;
    double r_theta = 0.0;
    double r_z = 0.0;
    for (std::size_t n = 0; n < row.index.size(); ++n) {
      const double c = surface.coefficients()[static_cast<Eigen::Index>(row.index[n])];
      r += row.value[n] * c;
      r_theta += row.theta[n] * c;
      r_z += row.z[n] * c;
    }
    const RadiusJet jet = surface.Jet(t, z);
    EXPECT_NEAR(r, surface.Radius(t, z), 1e-11);
    EXPECT_NEAR(r_theta, jet.r_theta, 1e-10);
    EXPECT_NEAR(r_z, jet.r_z, 1e-11);
  }
}

TEST(SplineSurface, NormalIsPerpendicularToBothTangentsAndPointsOutward) {
  const SplineSurface surface = RandomSurface(6);
  std::mt19937_64 random(7);
  const double h = 1e-5;
  for (int k = 0; k < 200; ++k) {
    const double t = Uniform(random, 0.0, kTwoPi);
    const double z = Uniform(random, surface.z_min() + 1.0, surface.z_max() - 1.0);
    const Eigen::Vector3d normal = surface.Normal(t, z);
    EXPECT_NEAR(normal.norm(), 1.0, 1e-14);
    const Eigen::Vector3d around = (surface.Point(t + h, z) - surface.Point(t - h, z)).normalized();
    const Eigen::Vector3d up = (surface.Point(t, z + h) - surface.Point(t, z - h)).normalized();
    EXPECT_NEAR(normal.dot(around), 0.0, 1e-6);
    EXPECT_NEAR(normal.dot(up), 0.0, 1e-6);
    EXPECT_GT(normal.dot(PointFromCylindrical(t, 1.0, 0.0)), 0.0);
  }
}

TEST(SplineSurface, IsTheSameAfterAWholeTurn) {
  const SplineSurface surface = RandomSurface(8);
  for (double z = surface.z_min(); z <= surface.z_max(); z += 5.0) {
    EXPECT_EQ(surface.Radius(0.0, z), surface.Radius(kTwoPi, z));
    EXPECT_NEAR(surface.Radius(1.0, z), surface.Radius(1.0 - kTwoPi, z), 1e-11);
  }
}

TEST(SplineSurface, NeedsOneCoefficientPerPairOfSplines) {
  EXPECT_THROW(SplineSurface(PeriodicCubicBasis(8), ClampedCubicBasis({0.0, 1.0}), Eigen::VectorXd::Zero(31)),
               LogicError);
}

}  // namespace
}  // namespace annulus
