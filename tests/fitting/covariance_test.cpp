#include "fitting/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "fitting/fit_surface.h"
#include "fitting/spline_surface.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::Uniform;

/// Normal matrix of random observations of a small surface, dense and as a sparse upper triangle.
struct Problem {
  SplineSurface surface;
  Eigen::SparseMatrix<double> upper;
  Eigen::MatrixXd dense;
};

Problem RandomProblem(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const PeriodicCubicBasis theta(11);
  const ClampedCubicBasis z(UniformBreakpoints(0.0, 60.0, 6));
  const auto size = static_cast<Eigen::Index>(theta.count() * z.count());
  SplineSurface surface(theta, z, Eigen::VectorXd::Constant(size, 100.0));
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(size, size) * 0.05;
  for (int k = 0; k < 400; ++k) {
    const double t = Uniform(random, 0.0, kTwoPi);
    const double height = Uniform(random, 0.0, 60.0);
    const double weight = Uniform(random, 0.1, 4.0);
    const RadiusRow row = surface.Row(t, height);
    for (std::size_t a = 0; a < 16; ++a) {
      for (std::size_t b = 0; b < 16; ++b) {
        dense(static_cast<Eigen::Index>(row.index[a]), static_cast<Eigen::Index>(row.index[b])) +=
            weight * row.value[a] * row.value[b];
      }
    }
  }
  const Eigen::MatrixXd upper = dense.triangularView<Eigen::Upper>();
  return {std::move(surface), upper.sparseView(), std::move(dense)};
}

TEST(SurfaceCovariance, GivesTheVarianceOfTheDenseInverse) {
  const Problem problem = RandomProblem(2);
  const Eigen::MatrixXd inverse = problem.dense.inverse();
  const auto covariance = SurfaceCovariance::FromNormalMatrix(problem.upper);
  ASSERT_TRUE(covariance.has_value()) << covariance.error().Text();
  std::mt19937_64 random(3);
  for (int k = 0; k < 50; ++k) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(problem.dense.rows());
    for (double& value : gradient) {
      if (random() % 3 == 0) value = Uniform(random, -2.0, 2.0);
    }
    const double expected = gradient.dot(inverse * gradient);
    EXPECT_NEAR(covariance->Variance(gradient), expected, 1e-10 * expected);
  }
}

TEST(SurfaceCovariance, GivesTheLocalVarianceOfTheDenseInverseEverywhere) {
  const Problem problem = RandomProblem(4);
  const Eigen::MatrixXd inverse = problem.dense.inverse();
  const auto covariance = SurfaceCovariance::FromNormalMatrix(problem.upper);
  ASSERT_TRUE(covariance.has_value());
  std::mt19937_64 random(5);
  for (int k = 0; k < 500; ++k) {
    const RadiusRow row = problem.surface.Row(Uniform(random, 0.0, kTwoPi), Uniform(random, 0.0, 60.0));
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(problem.dense.rows());
    std::vector<CoefficientWeight> local;
    for (std::size_t n = 0; n < 16; ++n) {
      gradient[static_cast<Eigen::Index>(row.index[n])] += row.value[n];
      local.push_back({row.index[n], row.value[n]});
    }
    const double expected = gradient.dot(inverse * gradient);
    EXPECT_NEAR(covariance->LocalVariance(local), expected, 1e-10 * expected);
  }
}

TEST(SurfaceCovariance, TakesAMatrixWithFewerEntriesThanTheSurfaceCouples) {
  // A model file may carry any positive definite matrix, here 4·I: the variance of Σ w c is Σ w²/4.
  const Problem problem = RandomProblem(7);
  Eigen::SparseMatrix<double> diagonal(problem.dense.rows(), problem.dense.cols());
  diagonal.setIdentity();
  diagonal *= 4.0;
  const auto covariance = SurfaceCovariance::FromNormalMatrix(diagonal);
  ASSERT_TRUE(covariance.has_value());
  const RadiusRow row = problem.surface.Row(1.0, 30.0);
  std::vector<CoefficientWeight> local;
  double expected = 0.0;
  for (std::size_t n = 0; n < 16; ++n) {
    local.push_back({row.index[n], row.value[n]});
    expected += row.value[n] * row.value[n] / 4.0;
  }
  EXPECT_NEAR(covariance->LocalVariance(local), expected, 1e-14);
}

/// A scan of a trunk with a bump, so that its spline is refined, with its normal matrix.
SurfaceSegment RefinedSegment() {
  test::ScanShape shape;
  shape.levels = 40;
  shape.sensors = 48;
  shape.noise = 0.3;
  const auto bumpy = [](double theta, double z) {
    return test::SmoothTrunk(theta, z) +
           12.0 * std::exp(-std::pow((theta - 3.0) / 0.15, 2) - std::pow((z - 90.0) / 9.0, 2));
  };
  auto fit = FitSurface(test::SyntheticScan(bumpy, shape), {}, {});
  if (!fit) throw std::runtime_error(fit.error().Text());
  return std::move(fit->model.segments.front());
}

TEST(SurfaceCovariance, OfARefinedSplineIsTheDenseInverse) {
  const SurfaceSegment segment = RefinedSegment();
  const std::vector<SplineLeaf>& leaves = segment.hierarchy->leaves();
  ASSERT_TRUE(std::any_of(leaves.begin(), leaves.end(), [](const SplineLeaf& leaf) { return !leaf.plain; }));
  const Eigen::MatrixXd upper = segment.normal_matrix;
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(upper.selfadjointView<Eigen::Upper>()).inverse();
  const auto covariance = SurfaceCovariance::FromNormalMatrix(segment.normal_matrix, *segment.hierarchy);
  ASSERT_TRUE(covariance.has_value()) << covariance.error().Text();
  std::mt19937_64 random(9);
  for (int k = 0; k < 300; ++k) {
    const std::vector<CoefficientWeight> local = segment.hierarchy->ActiveRow(
        Uniform(random, 0.0, kTwoPi), Uniform(random, segment.surface.z_min(), segment.surface.z_max()));
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(inverse.rows());
    for (const CoefficientWeight& w : local) gradient[static_cast<Eigen::Index>(w.index)] += w.weight;
    const double expected = gradient.dot(inverse * gradient);
    EXPECT_NEAR(covariance->LocalVariance(local), expected, 1e-9 * expected);
    EXPECT_NEAR(covariance->Variance(gradient), expected, 1e-9 * expected);
  }
}

TEST(SurfaceCovariance, TakesAMatrixThatCouplesMoreThanTheSplineDoes) {
  SurfaceSegment segment = RefinedSegment();
  const Eigen::Index n = segment.normal_matrix.cols();
  segment.normal_matrix.coeffRef(0, n - 1) += 1e-3;
  const Eigen::MatrixXd upper = segment.normal_matrix;
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(upper.selfadjointView<Eigen::Upper>()).inverse();
  const auto covariance = SurfaceCovariance::FromNormalMatrix(segment.normal_matrix, *segment.hierarchy);
  ASSERT_TRUE(covariance.has_value());
  const std::vector<CoefficientWeight> local = segment.hierarchy->ActiveRow(0.1, segment.surface.z_max());
  double expected = 0.0;
  for (const CoefficientWeight& a : local) {
    for (const CoefficientWeight& b : local) {
      expected += a.weight * b.weight * inverse(static_cast<Eigen::Index>(a.index), static_cast<Eigen::Index>(b.index));
    }
  }
  EXPECT_NEAR(covariance->LocalVariance(local), expected, 1e-9 * expected);
}

TEST(SurfaceCovariance, OfARefinedSplineRefusesAMatrixThatIsNotPositiveDefinite) {
  SurfaceSegment segment = RefinedSegment();
  segment.normal_matrix.coeffRef(5, 5) = -1.0;
  EXPECT_FALSE(SurfaceCovariance::FromNormalMatrix(segment.normal_matrix, *segment.hierarchy).has_value());
  segment.normal_matrix.coeffRef(5, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(SurfaceCovariance::FromNormalMatrix(segment.normal_matrix, *segment.hierarchy).has_value());
  segment.normal_matrix.resize(3, 3);
  segment.normal_matrix.setIdentity();
  const auto other = SurfaceCovariance::FromNormalMatrix(segment.normal_matrix, *segment.hierarchy);
  EXPECT_FALSE(other.has_value());
}

TEST(SurfaceCovariance, RefusesAMatrixThatIsNotPositiveDefinite) {
  Problem problem = RandomProblem(6);
  problem.upper.coeffRef(3, 3) = -1.0;
  const auto indefinite = SurfaceCovariance::FromNormalMatrix(problem.upper);
  ASSERT_FALSE(indefinite.has_value());
  EXPECT_FALSE(indefinite.error().seen.empty());
  Eigen::SparseMatrix<double> zero(5, 5);
  EXPECT_FALSE(SurfaceCovariance::FromNormalMatrix(zero).has_value());
}

}  // namespace
}  // namespace annulus
