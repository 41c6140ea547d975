#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fitting/directional_smoothing.h"
#include "fitting/frontal_cholesky.h"
#include "fitting/residual_maps.h"
#include "fitting/robust_cost.h"
#include "fitting/sample_screening.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::Uniform;

Eigen::MatrixXd Full(const Eigen::SparseMatrix<double>& upper) {
  return Eigen::MatrixXd(Eigen::MatrixXd(upper).selfadjointView<Eigen::Upper>());
}

/// A small scan with holes, and a spline over it that is refined around two places.
struct Problem {
  std::vector<SurfaceSample> samples;
  std::vector<char> use;
  std::unique_ptr<const CellGrid> cells;
  std::unique_ptr<const HierarchicalSpline> basis;
  std::unique_ptr<const SplineSystem> system;
  RoughnessWeights weights;
  static constexpr double kNoise = 0.4;

  explicit Problem(bool refined = true) {
    test::ScanShape shape;
    shape.levels = 30;
    shape.sensors = 32;
    shape.noise = kNoise;
    samples = test::SyntheticScan(test::SmoothTrunk, shape);
    std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor >= 20 && s.sensor < 24 && s.level < 9; });
    std::mt19937_64 random(5);
    for (SurfaceSample& s : samples) s.weight = static_cast<float>(Uniform(random, 0.5, 1.5));
    const SampleGrid grid(samples);
    const std::vector<SampleVerdict> verdicts(samples.size(), SampleVerdict::kGood);
    use.assign(samples.size(), 1);
    cells = std::make_unique<const CellGrid>(samples, grid, verdicts);
    RefinementFlags flags;
    if (refined) {
      flags = {std::vector<char>(8 * 7, 0), std::vector<char>(16 * 14, 0)};
      for (std::size_t j = 1; j < 6; ++j) {
        for (std::size_t i : {6U, 7U, 0U, 1U, 2U}) flags[0][j * 8 + i] = 1;  // across theta = 0
      }
      for (std::size_t j = 4; j < 10; ++j) {
        for (std::size_t i : {14U, 15U, 0U, 1U, 2U}) flags[1][j * 16 + i] = 1;
      }
    }
    basis = std::make_unique<const HierarchicalSpline>(8, UniformBreakpoints(cells->z_min(), cells->z_max(), 7), flags);
    system = std::make_unique<const SplineSystem>(*basis, UsedSamples{samples, use, kNoise}, *cells);
    weights.cells.resize(cells->columns() * cells->rows());
    for (CellBend& w : weights.cells)
      w = {Uniform(random, 0.1, 5.0), Uniform(random, 0.1, 5.0), Uniform(random, 0.1, 5.0)};
  }

  [[nodiscard]] Eigen::VectorXd Random(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    Eigen::VectorXd x(static_cast<Eigen::Index>(basis->size()));
    for (double& v : x) v = Uniform(random, -1.0, 1.0);
    return x;
  }
  /// A as a full matrix, from its sparse upper triangle.
  [[nodiscard]] Eigen::MatrixXd Dense() const { return Full(system->NormalMatrix(weights, {})); }
  /// B: one row per row of the system, from the spline's own evaluation.
  [[nodiscard]] Eigen::MatrixXd DesignMatrix() const {
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(system->rows().size()),
                                              static_cast<Eigen::Index>(basis->size()));
    for (std::size_t k = 0; k < system->rows().size(); ++k) {
      const SurfaceSample& s = samples[system->rows()[k].sample];
      for (const CoefficientWeight& w : basis->ActiveRow(s.theta, s.z)) {
        b(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(w.index)) += w.weight;
      }
    }
    return b;
  }
};

TEST(HierarchicalSpline, IsThePartitionOfUnityEverywhere) {
  const Problem problem;
  std::mt19937_64 random(1);
  for (int k = 0; k < 500; ++k) {
    double sum = 0.0;
    for (const CoefficientWeight& w :
         problem.basis->ActiveRow(Uniform(random, 0.0, kTwoPi), Uniform(random, 0.0, problem.cells->z_max()))) {
      sum += w.weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(HierarchicalSpline, IsItsTensorSurface) {
  const Problem problem;
  const Eigen::VectorXd c = problem.Random(2);
  const SplineSurface surface = problem.basis->Surface(c);
  std::mt19937_64 random(3);
  for (int k = 0; k < 500; ++k) {
    const double theta = Uniform(random, 0.0, kTwoPi);
    const double z = Uniform(random, 0.0, problem.cells->z_max());
    double value = 0.0;
    for (const CoefficientWeight& w : problem.basis->ActiveRow(theta, z)) {
      value += w.weight * c[static_cast<Eigen::Index>(w.index)];
    }
    EXPECT_NEAR(surface.Radius(theta, z), value, 1e-12);
  }
}

TEST(HierarchicalSpline, ItsGradientIsTheTransposeOfItsSurface) {
  // <g, S c> = <Sᵀ g, c> for any g and c.
  const Problem problem;
  const Eigen::VectorXd c = problem.Random(4);
  const Eigen::VectorXd tensor = problem.basis->Surface(c).coefficients();
  std::mt19937_64 random(5);
  Eigen::VectorXd g(tensor.size());
  for (double& v : g) v = Uniform(random, -1.0, 1.0);
  EXPECT_NEAR(g.dot(tensor), problem.basis->ActiveGradient(g).dot(c), 1e-10);
}

TEST(EliminationTree, NumbersEveryCoefficientOnceAndChildrenBeforeParents) {
  const Problem problem;
  const EliminationTree tree(*problem.basis);
  std::vector<std::uint32_t> sorted = tree.position();
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k < sorted.size(); ++k) EXPECT_EQ(sorted[k], k);
  for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
    const EliminationNode& node = tree.nodes()[n];
    EXPECT_LT(node.left, static_cast<std::int32_t>(n));
    EXPECT_LT(node.right, static_cast<std::int32_t>(n));
    for (const std::uint32_t position : tree.Boundary(node)) EXPECT_GE(position, node.own_first + node.own_count);
  }
  EXPECT_EQ(tree.nodes().back().boundary_count, 0U);
}

TEST(SplineSystem, PredictsAndTransposesAsTheSplineEvaluates) {
  const Problem problem;
  const Eigen::MatrixXd b = problem.DesignMatrix();
  const Eigen::VectorXd c = problem.Random(6);
  EXPECT_LE((problem.system->Predict(c) - b * c).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::VectorXd residuals = problem.system->Residuals(c);
  EXPECT_LE((problem.system->Transpose(residuals) - b.transpose() * residuals).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(SplineSystem, HasTheNormalMatrixOfItsRowsAndSecondDifferences) {
  // A = BᵀWB/σ² + Σ weights · (second differences)², the latter from the surface's own derivatives at the cells.
  const Problem problem;
  const Eigen::VectorXd c = problem.Random(7);
  const SplineSurface surface = problem.basis->Surface(c);
  const CellGrid& cells = *problem.cells;
  double expected = 0.0;
  for (std::size_t k = 0; k < problem.system->rows().size(); ++k) {
    const SampleRow& row = problem.system->rows()[k];
    const SurfaceSample& s = problem.samples[row.sample];
    const double value = surface.Radius(s.theta, s.z) / Problem::kNoise;
    expected += static_cast<double>(s.weight) * value * value;
  }
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const RadiusJet jet = surface.Jet(cells.theta(column), cells.z(row));
      const CellBend& w = problem.weights.cells[cells.Index(column, row)];
      const double u = cells.theta_step();
      const double v = cells.z_step();
      expected += w.uu * std::pow(jet.r_theta_theta * u * u, 2) + w.vv * std::pow(jet.r_z_z * v * v, 2) +
                  w.uv * std::pow(jet.r_theta_z * u * v, 2);
      if (cells.count(column, row) > 0) continue;
      expected += (std::pow(jet.r_theta * u, 2) + std::pow(jet.r_z * v, 2)) / (kHoleSlope * kHoleSlope);
    }
  }
  EXPECT_NEAR(c.dot(problem.Dense() * c), expected, 1e-6 * expected);
}

TEST(FrontalCholesky, SolvesAsADenseFactorDoes) {
  for (const bool refined : {false, true}) {
    const Problem problem(refined);
    const auto tree = std::make_shared<const EliminationTree>(*problem.basis);
    const auto factor = problem.system->Factor(tree, problem.weights, {});
    ASSERT_TRUE(factor.has_value());
    const Eigen::MatrixXd a = problem.Dense();
    const Eigen::VectorXd b = problem.Random(8);
    const Eigen::VectorXd expected = a.ldlt().solve(b);
    EXPECT_LE((factor->Solve(b) - expected).norm(), 1e-9 * expected.norm());
    // The two triangles: ‖L⁻¹Pb‖² = bᵀA⁻¹b, and the upper after the lower is the whole.
    EXPECT_NEAR(factor->SolveLower(b).squaredNorm(), b.dot(expected), 1e-9 * std::abs(b.dot(expected)));
    EXPECT_LE((factor->SolveUpper(factor->SolveLower(b)) - expected).norm(), 1e-9 * expected.norm());
    FrontalCholesky::FourColumns four(b.size(), 4);
    for (Eigen::Index k = 0; k < 4; ++k) four.col(k) = problem.Random(9 + static_cast<std::uint64_t>(k));
    EXPECT_LE((factor->Solve(four) - a.ldlt().solve(Eigen::MatrixXd(four))).norm(), 1e-9 * four.norm());
  }
}

TEST(FrontalCholesky, RefusesAMatrixThatIsNotPositiveDefinite) {
  const Problem problem;
  RoughnessWeights negative = problem.weights;
  for (CellBend& w : negative.cells) w.uu = -1e6;
  EXPECT_FALSE(
      problem.system->Factor(std::make_shared<const EliminationTree>(*problem.basis), negative, {}).has_value());
}

TEST(DirectionalGcv, IsTheScoreOfTheDenseSmoother) {
  // n·RSS/(n − trace S)² with S = 2H − H², H = B A⁻¹ BᵀW/σ², by dense algebra; the traces by probes are within 3 %.
  const Problem problem(false);
  const auto tree = std::make_shared<const EliminationTree>(*problem.basis);
  const DirectionalGcv score(*problem.system, tree, problem.weights, {});
  const DirectionalSmoothing smoothing{3.0, 0.5};
  const Eigen::MatrixXd b = problem.DesignMatrix();
  Eigen::VectorXd w(b.rows());
  for (Eigen::Index k = 0; k < w.size(); ++k) {
    w[k] = static_cast<double>(problem.system->rows()[static_cast<std::size_t>(k)].weight);
  }
  const Eigen::MatrixXd a = Full(problem.system->NormalMatrix(Scaled(problem.weights, smoothing), {}));
  const Eigen::MatrixXd h =
      b * a.ldlt().solve(b.transpose() * Eigen::MatrixXd(w.asDiagonal())) / (Problem::kNoise * Problem::kNoise);
  const Eigen::MatrixXd s = 2.0 * h - h * h;
  const Eigen::VectorXd y = problem.system->Radii();
  const Eigen::VectorXd r = y - s * y;
  const auto n = static_cast<double>(y.size());
  const double expected = n * r.dot(w.asDiagonal() * r) / std::pow(n - s.trace(), 2);
  EXPECT_NEAR(score.At(smoothing), expected, 0.03 * expected);
}

/// The problem with every 17th sample 9 mm off, solved by least squares.
struct SpoiltProblem {
  Problem problem;
  std::optional<FrontalCholesky> factor;
  Eigen::VectorXd start;
  std::vector<double> scales;

  SpoiltProblem() {
    for (std::size_t k = 0; k < problem.samples.size(); k += 17) problem.samples[k].radius += 9.0;
    problem.system = std::make_unique<const SplineSystem>(
        *problem.basis, UsedSamples{problem.samples, problem.use, Problem::kNoise, {}}, *problem.cells);
    factor = problem.system->Factor(std::make_shared<const EliminationTree>(*problem.basis), problem.weights, {});
    start = factor->Solve(problem.system->WeightedTranspose(problem.system->Radii(), {}));
    scales.assign(problem.system->rows().size(), 1.3);
  }
  [[nodiscard]] RobustCost Cost() const { return {*problem.system, *factor, start, scales}; }
};

TEST(RobustCost, HasTheGradientOfItsDifferences) {
  const SpoiltProblem spoilt;
  const Problem& problem = spoilt.problem;
  const RobustCost cost = spoilt.Cost();
  const Eigen::VectorXd y = problem.Random(11);
  const Eigen::VectorXd gradient = cost.At(y).gradient;
  for (Eigen::Index k = 0; k < y.size(); k += 7) {
    constexpr double kStep = 1e-5;
    Eigen::VectorXd moved = y;
    moved[k] = y[k] + kStep;
    const double above = cost.At(moved).cost;
    moved[k] = y[k] - kStep;
    const double below = cost.At(moved).cost;
    EXPECT_NEAR(gradient[k], (above - below) / (2.0 * kStep), 1e-4 * (1.0 + std::abs(gradient[k]))) << k;
  }
}

TEST(RobustCost, IsTheHuberCostOfTheResidualsAndThePenalty) {
  // Differences of ½Σ w s²ρ(r²/(σs)²) + ½cᵀPc between two places, with P = A − BᵀWB/σ² by dense algebra.
  const SpoiltProblem spoilt;
  const Problem& problem = spoilt.problem;
  const RobustCost cost = spoilt.Cost();
  const Eigen::MatrixXd b = problem.DesignMatrix();
  Eigen::VectorXd w(b.rows());
  for (Eigen::Index k = 0; k < w.size(); ++k) {
    w[k] = static_cast<double>(problem.system->rows()[static_cast<std::size_t>(k)].weight);
  }
  const double variance = Problem::kNoise * Problem::kNoise;
  const Eigen::MatrixXd p = problem.Dense() - b.transpose() * w.asDiagonal() * b / variance;
  const auto huber = [&](const Eigen::VectorXd& c) {
    const Eigen::VectorXd r = problem.system->Radii() - b * c;
    double sum = 0.5 * c.dot(p * c);
    for (Eigen::Index k = 0; k < r.size(); ++k) {
      const double t = std::abs(r[k]) / (Problem::kNoise * 1.3);
      sum += 0.5 * w[k] * 1.3 * 1.3 * (t <= kHuberWidth ? t * t : 2.0 * kHuberWidth * t - kHuberWidth * kHuberWidth);
    }
    return sum;
  };
  const Eigen::VectorXd y0 = problem.Random(12);
  const Eigen::VectorXd y1 = 3.0 * problem.Random(13);
  const double expected = huber(cost.Coefficients(y1)) - huber(cost.Coefficients(y0));
  EXPECT_NEAR(cost.At(y1).cost - cost.At(y0).cost, expected, 1e-6 * std::abs(expected) + 1e-6);
}

TEST(UnresolvedCells, AreWhereResidualsAreNotNoise) {
  const Problem problem;
  ResidualMaps maps;
  const std::size_t n = problem.cells->columns() * problem.cells->rows();
  maps.sum.assign(n, 0.0);
  maps.squares.assign(n, 0.0);
  maps.count.assign(n, 1.0);
  const FitInput input{problem.samples, problem.use, *problem.cells, 1.0};
  const auto flags_with = [&](std::size_t columns, std::size_t rows, double value) {
    ResidualMaps bumped = maps;
    for (std::size_t r = 10; r < 10 + rows; ++r) {
      for (std::size_t c = 0; c < columns; ++c) bumped.sum[problem.cells->Index(c, r)] = value;
    }
    const std::vector<char> flags = UnresolvedCells(input, bumped);
    return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 1));
  };
  EXPECT_EQ(flags_with(1, 1, 3.7), 0U);  // one cell: 3.7 standard deviations
  EXPECT_GT(flags_with(1, 1, 3.9), 0U);
  EXPECT_EQ(flags_with(3, 3, 1.25), 0U);  // nine cells: 11.25 against 3.8·3
  EXPECT_GT(flags_with(3, 3, 1.3), 0U);
  // Along a line that is certain at one end only, they go on: three cells of 1.3 are 2.25 standard deviations.
  ResidualMaps line = maps;
  for (std::size_t c = 0; c < 30; ++c) line.sum[problem.cells->Index(c, 12)] = c < 3 ? 4.0 : 1.3;
  const std::vector<char> flags = UnresolvedCells(input, line);
  for (std::size_t c = 0; c < 29; ++c) EXPECT_EQ(flags[problem.cells->Index(c, 12)], 1) << c;
}

}  // namespace
}  // namespace annulus
