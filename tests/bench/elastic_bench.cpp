#include <benchmark/benchmark.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "modeling/elastic/elastic_system.h"

namespace annulus::bench {
namespace {

/// A soft layer of 20 mm over a core of 130 mm with waves, 5,000 nodes in two layers of elements, a third of a turn
/// wide; a dent of 8 mm in its middle.
ElasticProblem Dented() {
  ElasticProblem problem;
  const GridShape shape{41, 41, 3, GridClosure::kOpen};
  problem.grid.shape = shape;
  problem.material = {0.01, 0.48};
  problem.held.assign(3 * shape.nodes(), 0);
  problem.given.assign(shape.nodes(), Eigen::Vector3d::Zero());
  for (std::size_t j = 0; j < shape.rows; ++j) {
    for (std::size_t i = 0; i < shape.columns; ++i) {
      const double theta = 0.05 * static_cast<double>(i);
      const double wave = 4.0 * std::sin(0.3 * static_cast<double>(i) + 0.2 * static_cast<double>(j));
      const Eigen::Vector3d out(std::cos(theta), std::sin(theta), 0.0);
      const double from_middle = std::hypot(static_cast<double>(i) - 20.0, static_cast<double>(j) - 20.0);
      const double share = std::max(0.0, 1.0 - from_middle * from_middle / 36.0);
      for (std::size_t k = 0; k < shape.layers; ++k) {
        const std::size_t node = problem.grid.nodes.size();
        problem.grid.nodes.emplace_back((130.0 + wave + 10.0 * static_cast<double>(k)) * out +
                                        7.0 * static_cast<double>(j) * Eigen::Vector3d::UnitZ());
        const bool rim = i == 0 || j == 0 || i + 1 == shape.columns || j + 1 == shape.rows;
        const bool pushed = k + 1 == shape.layers && share > 0.0;
        if (pushed) problem.given[node] = -8.0 * share * share * out;
        for (std::size_t c = 0; c < 3 && (k == 0 || rim || pushed); ++c) problem.held[3 * node + c] = 1;
      }
    }
  }
  return problem;
}

/// From nodes to the shape at rest.
void SolveRegion(benchmark::State& state) {
  const ElasticProblem problem = Dented();
  ElasticOptions options;
  options.method = state.range(0) == 0 ? ElasticMethod::kLinear : ElasticMethod::kCorotational;
  for (auto unused : state) {
    const auto solution = SolveElastic(problem, options, {});
    if (!solution) return state.SkipWithError(solution.error().Text().c_str());
    state.counters["steps"] = solution->steps;
    state.counters["residual"] = solution->residual;
  }
  state.counters["nodes"] = static_cast<double>(problem.grid.shape.nodes());
}
BENCHMARK(SolveRegion)->ArgName("corotational")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// Element matrices and an order of elimination for the solvers side by side.
struct Equations {
  ElasticProblem problem = Dented();
  std::vector<HexMatrix, Eigen::aligned_allocator<HexMatrix>> elements;

  Equations() {
    const GridShape& shape = problem.grid.shape;
    for (std::size_t e = 0; e < shape.elements(); ++e) {
      const auto nodes = problem.grid.NodesOf(e / (shape.layers - 1), e % (shape.layers - 1));
      HexCorners corners;
      for (int a = 0; a < 8; ++a) corners.col(a) = problem.grid.nodes[nodes[static_cast<std::size_t>(a)]];
      elements.push_back(*HexStiffness(corners, problem.material));
    }
  }
};

/// Assembly, factor and one solution: ours.
void FactorByStacks(benchmark::State& state) {
  const Equations equations;
  const GridShape& shape = equations.problem.grid.shape;
  const auto width = static_cast<Eigen::Index>(12 * shape.layers);
  Eigen::MatrixXd sum(width, width);
  const Eigen::VectorXd right = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(3 * shape.nodes()));
  for (auto unused : state) {
    const auto tree = std::make_shared<const StackTree>(shape, equations.problem.held);
    StackCholesky factor(tree);
    const bool positive = factor.Factor([&](std::size_t pile) {
      sum.setZero();
      for (std::size_t level = 0; level + 1 < shape.layers; ++level) {
        const HexMatrix& element = equations.elements[pile * (shape.layers - 1) + level];
        for (std::size_t a = 0; a < 8; ++a) {
          for (std::size_t b = 0; b < 8; ++b) {
            sum.block<3, 3>(static_cast<Eigen::Index>(3 * (a % 4 * shape.layers + level + a / 4)),
                            static_cast<Eigen::Index>(3 * (b % 4 * shape.layers + level + b / 4))) +=
                element.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b));
          }
        }
      }
      return sum.data();
    });
    if (!positive) return state.SkipWithError("not positive definite");
    benchmark::DoNotOptimize(factor.Solve(right));
  }
}
BENCHMARK(FactorByStacks)->Unit(benchmark::kMillisecond);

/// The same by Eigen's sparse Cholesky (minimum degree): the peer.
void FactorByEigen(benchmark::State& state) {
  const Equations equations;
  const GridShape& shape = equations.problem.grid.shape;
  std::vector<int> number(equations.problem.held.size(), -1);
  int count = 0;
  for (std::size_t k = 0; k < number.size(); ++k) {
    if (equations.problem.held[k] == 0) number[k] = count++;
  }
  for (auto unused : state) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < equations.elements.size(); ++e) {
      const auto nodes = equations.problem.grid.NodesOf(e / (shape.layers - 1), e % (shape.layers - 1));
      for (std::size_t b = 0; b < 24; ++b) {
        for (std::size_t a = 0; a < 24; ++a) {
          const int row = number[3 * nodes[a / 3] + a % 3];
          const int column = number[3 * nodes[b / 3] + b % 3];
          if (column >= 0 && row >= column) {
            entries.emplace_back(row, column,
                                 equations.elements[e](static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
          }
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(matrix);
    const Eigen::VectorXd right = Eigen::VectorXd::Ones(count);
    const Eigen::VectorXd solved = factor.solve(right);
    benchmark::DoNotOptimize(solved.data());
  }
}
BENCHMARK(FactorByEigen)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
