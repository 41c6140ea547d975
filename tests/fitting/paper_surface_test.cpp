#include "fitting/paper_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "base/frames.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

struct Net {
  std::vector<double> theta;
  std::vector<double> z;
  Eigen::MatrixXd radius;
};

/// Unequal knots on a body with waves both ways.
Net WavyNet() {
  Net net;
  for (int i = 0; i < 24; ++i) net.theta.push_back(0.1 + kTwoPi * i / 24.0 + 0.05 * std::sin(2.0 * i));
  for (int j = 0; j < 15; ++j) net.z.push_back(-40.0 + 20.0 * j + 5.0 * std::sin(1.3 * j));
  net.radius.resize(15, 24);
  for (Eigen::Index j = 0; j < 15; ++j) {
    for (Eigen::Index i = 0; i < 24; ++i) {
      net.radius(j, i) = test::SmoothTrunk(net.theta[static_cast<std::size_t>(i)], net.z[static_cast<std::size_t>(j)]);
    }
  }
  return net;
}

PaperSurface Wavy() {
  const Net net = WavyNet();
  auto surface = PaperSurface::Through(net.theta, net.z, net.radius);
  EXPECT_TRUE(surface.has_value());
  return *surface;
}

// On a circle all control points lie at R·6/(4 + 2 cos(2 pi/m)).
TEST(ClosedControlPoints, OfACircleLieOnACircle) {
  constexpr Eigen::Index kCount = 12;
  Eigen::MatrixXd points(kCount, 2);
  for (Eigen::Index k = 0; k < kCount; ++k) {
    const double angle = kTwoPi * static_cast<double>(k) / kCount;
    points.row(k) << 100.0 * std::cos(angle), 100.0 * std::sin(angle);
  }
  const Eigen::MatrixXd control = ClosedControlPoints(points);
  for (Eigen::Index k = 0; k < kCount; ++k) {
    EXPECT_NEAR(control.row(k).norm(), 600.0 / (4.0 + 2.0 * std::cos(kTwoPi / kCount)), 1e-10);
  }
}

// Two points a, b: Q0 = Q1, Q2 = Q3 and (Q0 + 4 Q1 + Q2)/6 = a give Q1 = (5a - b)/4, Q2 = (5b - a)/4.
TEST(OpenControlPoints, OfTwoPointsAreTheirClosedForm) {
  const Eigen::MatrixXd control = OpenControlPoints((Eigen::MatrixXd(2, 1) << 3.0, 7.0).finished());
  ASSERT_EQ(control.rows(), 4);
  EXPECT_NEAR(control(0, 0), 2.0, 1e-13);
  EXPECT_NEAR(control(1, 0), 2.0, 1e-13);
  EXPECT_NEAR(control(2, 0), 8.0, 1e-13);
  EXPECT_NEAR(control(3, 0), 8.0, 1e-13);
}

TEST(PaperSurface, PassesThroughEveryKnotPoint) {
  const Net net = WavyNet();
  const PaperSurface surface = Wavy();
  for (std::size_t j = 0; j < net.z.size(); ++j) {
    for (std::size_t i = 0; i < net.theta.size(); ++i) {
      const double r = net.radius(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i));
      const Eigen::Vector3d expected = PointFromCylindrical(net.theta[i], r, net.z[j]);
      const Eigen::Vector3d point = surface.PointAt({static_cast<double>(i), static_cast<double>(j)});
      EXPECT_LE((point - expected).norm(), 1e-9);
      EXPECT_NEAR(surface.Radius(net.theta[i], net.z[j]), r, 1e-9);
    }
  }
}

TEST(PaperSurface, IsClosedAndSmoothOverTheSeam) {
  const PaperSurface surface = Wavy();
  const SurfacePartials first = surface.Partials({0.0, 3.4});
  const SurfacePartials last = surface.Partials({24.0 - 1e-9, 3.4});
  EXPECT_LE((first.point - last.point).norm(), 1e-6);
  EXPECT_LE((first.u - last.u).norm(), 1e-6);
  EXPECT_LE((first.uu - last.uu).norm(), 1e-5);
}

TEST(PaperSurface, EndsWithoutCurvatureThoughWithASecondDerivative) {
  const PaperSurface surface = Wavy();
  for (const double v : {0.0, 14.0}) {
    const SurfacePartials end = surface.Partials({5.3, v});
    EXPECT_LE(end.v.cross(end.vv).norm(), 1e-9 * end.v.norm() * end.vv.norm());
    EXPECT_GT(end.vv.norm(), 1.0);
  }
}

TEST(PaperSurface, SolvesUAndVToTheLastDigits) {
  const PaperSurface surface = Wavy();
  std::mt19937_64 random(3);
  for (int k = 0; k < 20000; ++k) {
    const double theta = test::Uniform(random, -7.0, 14.0);
    const double z = test::Uniform(random, surface.z_min(), surface.z_max());
    const SurfaceParameters at = surface.Solve(theta, z);
    const Eigen::Vector3d point = surface.PointAt(at);
    ASSERT_NEAR(AngleDifference(std::atan2(point.y(), point.x()), theta), 0.0, 1e-12);
    ASSERT_NEAR(point.z(), z, 1e-10);
    ASSERT_GE(at.u, 0.0);
    ASSERT_LT(at.u, 24.0);
  }
}

TEST(PaperSurface, TakesHeightsBeyondItsEndsToTheEnds) {
  const PaperSurface surface = Wavy();
  EXPECT_EQ(surface.Radius(1.0, -1e9), surface.Radius(1.0, surface.z_min()));
  EXPECT_EQ(surface.Radius(1.0, 1e9), surface.Radius(1.0, surface.z_max()));
}

TEST(PaperSurface, HasTheDerivativesOfItsRadius) {
  const PaperSurface surface = Wavy();
  constexpr double kTheta = 1e-4;
  constexpr double kZ = 1e-2;
  std::mt19937_64 random(5);
  for (int k = 0; k < 200; ++k) {
    const double t = test::Uniform(random, 0.0, kTwoPi);
    const double z = test::Uniform(random, surface.z_min() + 1.0, surface.z_max() - 1.0);
    const auto r = [&](double dt, double dz) { return surface.Radius(t + dt * kTheta, z + dz * kZ); };
    const RadiusJet jet = surface.Jet(t, z);
    EXPECT_NEAR(jet.r, r(0, 0), 1e-12);
    EXPECT_NEAR(jet.r_theta, (r(1, 0) - r(-1, 0)) / (2 * kTheta), 1e-3);
    EXPECT_NEAR(jet.r_z, (r(0, 1) - r(0, -1)) / (2 * kZ), 1e-5);
    // Third derivatives jump at knot lines: the second ones are compared loosely.
    EXPECT_NEAR(jet.r_theta_theta, (r(1, 0) - 2 * r(0, 0) + r(-1, 0)) / (kTheta * kTheta), 2.0);
    EXPECT_NEAR(jet.r_z_z, (r(0, 1) - 2 * r(0, 0) + r(0, -1)) / (kZ * kZ), 1e-3);
    EXPECT_NEAR(jet.r_theta_z, (r(1, 1) - r(1, -1) - r(-1, 1) + r(-1, -1)) / (4 * kTheta * kZ), 2e-2);
  }
}

TEST(PaperSurface, PointsItsNormalOutwardAcrossTheSurface) {
  const PaperSurface surface = Wavy();
  const Eigen::Vector3d normal = surface.Normal(2.0, 100.0);
  const Eigen::Vector3d point = surface.Point(2.0, 100.0);
  EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
  EXPECT_GT(normal.head<2>().dot(point.head<2>()), 0.0);
  EXPECT_NEAR(normal.dot(surface.Point(2.0 + 1e-6, 100.0) - point), 0.0, 1e-8);
  EXPECT_NEAR(normal.dot(surface.Point(2.0, 100.0 + 1e-4) - point), 0.0, 1e-7);
}

TEST(PaperSurface, RefusesWhatIsNoStarOfSections) {
  const Net net = WavyNet();
  const PaperSurface good = Wavy();
  const auto refused = [&](const std::vector<double>& theta, const std::vector<double>& z,
                           std::vector<Eigen::Vector3d> control) {
    return !PaperSurface::FromControlPoints(theta, z, std::move(control)).has_value();
  };
  EXPECT_FALSE(refused(net.theta, net.z, good.control()));

  std::vector<Eigen::Vector3d> bad = good.control();
  bad[100].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused(net.theta, net.z, bad));
  bad = good.control();
  bad[100].z() += 1.0;  // z not the same along u
  EXPECT_TRUE(refused(net.theta, net.z, bad));
  bad = good.control();
  bad[0].x() += 1e-6;  // Q0 = Q1 broken
  EXPECT_TRUE(refused(net.theta, net.z, bad));
  bad = good.control();
  bad.pop_back();
  EXPECT_TRUE(refused(net.theta, net.z, bad));
  bad = good.control();
  std::swap(bad[100], bad[101]);  // a fold
  EXPECT_TRUE(refused(net.theta, net.z, bad));
  std::vector<double> theta = net.theta;
  theta[3] += 0.01;  // a knot line elsewhere
  EXPECT_TRUE(refused(theta, net.z, good.control()));
  std::vector<double> z = net.z;
  std::swap(z[3], z[4]);
  EXPECT_TRUE(refused(net.theta, z, good.control()));

  Eigen::MatrixXd radius = net.radius;
  radius(5, 7) = -100.0;
  EXPECT_FALSE(PaperSurface::Through(net.theta, net.z, radius).has_value());
  radius(5, 7) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(PaperSurface::Through(net.theta, net.z, radius).has_value());
}

TEST(TurnsBack, TellsAStarFromAFold) {
  Eigen::MatrixXd circle(8, 2);
  for (Eigen::Index k = 0; k < 8; ++k) {
    const double angle = kTwoPi * static_cast<double>(k) / 8.0;
    circle.row(k) << std::cos(angle), std::sin(angle);
  }
  EXPECT_FALSE(TurnsBack(circle));
  circle.row(3).swap(circle.row(4));
  EXPECT_TRUE(TurnsBack(circle));
}

TEST(ApproximateByTensor, StaysWithinAHundredthOfAMillimetre) {
  const PaperSurface surface = Wavy();
  const TensorApproximation tensor = ApproximateByTensor(surface);
  EXPECT_LE(tensor.largest_error, 0.01);
  std::mt19937_64 random(9);
  for (int k = 0; k < 5000; ++k) {
    const double theta = test::Uniform(random, 0.0, kTwoPi);
    const double z = test::Uniform(random, surface.z_min(), surface.z_max());
    EXPECT_NEAR(tensor.surface.Radius(theta, z), surface.Radius(theta, z), 0.012);
  }
}

}  // namespace
}  // namespace annulus
