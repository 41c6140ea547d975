#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "modeling/elastic/elastic_solver.h"

namespace annulus::test {

/// A repeatable number from -1 to 1 for each n.
inline double Wobble(std::size_t n) {
  return 2.0 * static_cast<double>((static_cast<std::uint64_t>(n) * 2654435761ULL) % 10007) / 10006.0 - 1.0;
}

/// A block from the origin to `size`, mm, nothing held; columns along x, rows along y, layers along z.
inline ElasticProblem Block(const GridShape& shape, const Eigen::Vector3d& size, const ElasticMaterial& material) {
  ElasticProblem problem;
  problem.grid.shape = shape;
  problem.material = material;
  for (std::size_t j = 0; j < shape.rows; ++j) {
    for (std::size_t i = 0; i < shape.columns; ++i) {
      for (std::size_t k = 0; k < shape.layers; ++k) {
        problem.grid.nodes.emplace_back(size.x() * static_cast<double>(i) / static_cast<double>(shape.columns - 1),
                                        size.y() * static_cast<double>(j) / static_cast<double>(shape.rows - 1),
                                        size.z() * static_cast<double>(k) / static_cast<double>(shape.layers - 1));
      }
    }
  }
  problem.held.assign(3 * problem.grid.nodes.size(), 0);
  problem.given.assign(problem.grid.nodes.size(), Eigen::Vector3d::Zero());
  return problem;
}

inline void HoldNode(ElasticProblem& problem, std::size_t node, const Eigen::Vector3d& at) {
  problem.given[node] = at;
  for (std::size_t c = 0; c < 3; ++c) problem.held[3 * node + c] = 1;
}

/// A tube of one row of elements between two planes that neither let it move along z (plane strain); x or y is held
/// where the axes cut it, so that it stays where it is. Requires a multiple of four columns.
inline ElasticProblem Tube(std::size_t columns, std::size_t layers, double inner, double outer, double height,
                           const ElasticMaterial& material) {
  const GridShape shape{columns, 2, layers, GridClosure::kClosed};
  ElasticProblem problem;
  problem.grid.shape = shape;
  problem.material = material;
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < columns; ++i) {
      const double theta = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(columns);
      for (std::size_t k = 0; k < layers; ++k) {
        const double r = inner + (outer - inner) * static_cast<double>(k) / static_cast<double>(layers - 1);
        problem.grid.nodes.emplace_back(r * std::cos(theta), r * std::sin(theta), height * static_cast<double>(j));
      }
    }
  }
  problem.held.assign(3 * problem.grid.nodes.size(), 0);
  problem.given.assign(problem.grid.nodes.size(), Eigen::Vector3d::Zero());
  for (std::size_t n = 0; n < problem.grid.nodes.size(); ++n) {
    problem.held[3 * n + 2] = 1;
    const std::size_t column = n / layers % columns;
    if (column % (columns / 2) == 0) problem.held[3 * n + 1] = 1;
    if (column % (columns / 2) == columns / 4) problem.held[3 * n] = 1;
  }
  return problem;
}

inline double RadialMovement(const ElasticProblem& problem, const ElasticSolution& solution, std::size_t node) {
  const Eigen::Vector2d out = problem.grid.nodes[node].head<2>().normalized();
  return solution.displacement[node].head<2>().dot(out);
}

}  // namespace annulus::test
