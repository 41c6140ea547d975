#include "fitting/spline_transfer.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace annulus {
namespace {

using Eigen::Index;

std::vector<double> UnevenBreakpoints() { return {0.0, 30.0, 50.0, 95.0, 140.0, 160.0, 200.0, 260.0}; }

/// 12 × 7 cells, of which a block is split, and in the block a block.
RefinementFlags Coarse() {
  RefinementFlags flags{std::vector<char>(12 * 7, 0), std::vector<char>(24 * 14, 0)};
  for (std::size_t j = 1; j < 6; ++j) {
    for (std::size_t i = 2; i < 9; ++i) flags[0][j * 12 + i] = 1;
  }
  for (std::size_t j = 4; j < 9; ++j) {
    for (std::size_t i = 8; i < 14; ++i) flags[1][j * 24 + i] = 1;
  }
  return flags;
}

/// More of it: up to the lower end, across theta = 0, and a third level.
RefinementFlags Fine() {
  RefinementFlags flags = Coarse();
  for (std::size_t j = 0; j < 4; ++j) {
    for (const std::size_t i : std::vector<std::size_t>{10, 11, 0, 1, 2}) flags[0][j * 12 + i] = 1;
  }
  for (std::size_t j = 4; j < 12; ++j) {
    for (std::size_t i = 4; i < 9; ++i) flags[1][j * 24 + i] = 1;
  }
  flags.emplace_back(48 * 28, char{0});
  for (std::size_t j = 9; j < 16; ++j) {
    for (std::size_t i = 18; i < 26; ++i) flags[2][j * 48 + i] = 1;
  }
  return flags;
}

SurfaceSegment Random(unsigned seed) {
  auto spline = std::make_shared<const HierarchicalSpline>(12, UnevenBreakpoints(), Coarse());
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  Eigen::VectorXd active(static_cast<Index>(spline->size()));
  for (double& c : active) c = 100.0 + 10.0 * even(random);
  SurfaceSegment segment{"body", spline->Surface(active), KnowledgeMap(1, 1, 0.0, 260.0), {}};
  segment.hierarchy = spline;
  segment.active = active;
  return segment;
}

TEST(CoefficientTransfer, RefinesAndUndoesIt) {
  const SurfaceSegment segment = Random(1);
  const HierarchicalSpline fine(12, UnevenBreakpoints(), Fine());
  ASSERT_GT(fine.size(), segment.hierarchy->size() + 50);
  const Eigen::VectorXd refined = CoefficientTransfer(*segment.hierarchy, fine) * segment.active;
  const SplineSurface surface = fine.Surface(refined);
  for (int n = 0; n < 2000; ++n) {
    const double theta = 0.00314159 * n;
    const double z = 260.0 * std::fmod(0.6180339887 * n, 1.0);
    EXPECT_NEAR(surface.Radius(theta, z), segment.surface.Radius(theta, z), 1e-9);
  }
  const Eigen::VectorXd back = CoefficientTransfer(fine, *segment.hierarchy) * refined;
  EXPECT_LE((back - segment.active).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Refined, KeepsTheSurfaceAndTheVarianceOfWhatIsReadOffIt) {
  const SurfaceSegment segment = Random(2);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> even(0.0, 1.0);
  // Readings at random places, and a little of everything: a precision as a fit has it.
  const auto size = static_cast<Index>(segment.hierarchy->size());
  Eigen::MatrixXd precision = 0.02 * Eigen::MatrixXd::Identity(size, size);
  for (int n = 0; n < 500; ++n) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    for (const CoefficientWeight& entry : segment.hierarchy->ActiveRow(6.28 * even(random), 260.0 * even(random))) {
      row[static_cast<Index>(entry.index)] += entry.weight;
    }
    precision += 4.0 * row * row.transpose();
  }
  const Eigen::MatrixXd upper = precision.triangularView<Eigen::Upper>();
  const Eigen::MatrixXd covariance = precision.inverse();

  const SurfaceSegment refined =
      Refined(segment, std::make_shared<const HierarchicalSpline>(12, UnevenBreakpoints(), Fine()));
  const Eigen::SparseMatrix<double> matrix =
      RefinedPrecision(upper.sparseView(), *segment.hierarchy, *refined.hierarchy);
  const auto fitted = SurfaceCovariance::FromNormalMatrix(matrix, *refined.hierarchy);
  ASSERT_TRUE(fitted) << fitted.error().Text();
  for (int n = 0; n < 200; ++n) {
    const double theta = 6.28 * even(random);
    const double z = 260.0 * even(random);
    EXPECT_NEAR(refined.surface.Radius(theta, z), segment.surface.Radius(theta, z), 1e-9);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (const CoefficientWeight& entry : segment.hierarchy->ActiveRow(theta, z)) {
      gradient[static_cast<Index>(entry.index)] += entry.weight;
    }
    const double before = gradient.dot(covariance * gradient);
    EXPECT_NEAR(fitted->LocalVariance(refined.hierarchy->ActiveRow(theta, z)) / before, 1.0, 1e-4);
  }
}

TEST(Refined, TakesATensorSurface) {
  SurfaceSegment plain = Random(4);
  plain.hierarchy = nullptr;
  plain.active = {};
  const PeriodicCubicBasis theta(12);
  const ClampedCubicBasis z(UnevenBreakpoints());
  Eigen::VectorXd coefficients(12 * 10);
  for (Index n = 0; n < coefficients.size(); ++n) coefficients[n] = 100.0 + 7.0 * std::sin(static_cast<double>(n));
  plain.surface = SplineSurface(theta, z, coefficients);
  RefinementFlags flags = Coarse();
  const SurfaceSegment refined =
      Refined(plain, std::make_shared<const HierarchicalSpline>(12, UnevenBreakpoints(), flags));
  for (int n = 0; n < 500; ++n) {
    const double height = 260.0 * std::fmod(0.6180339887 * n, 1.0);
    EXPECT_NEAR(refined.surface.Radius(0.0123 * n, height), plain.surface.Radius(0.0123 * n, height), 1e-9);
  }
}

}  // namespace
}  // namespace annulus
