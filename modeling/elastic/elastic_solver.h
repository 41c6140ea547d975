#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/elastic/band_fibre.h"
#include "modeling/elastic/elastic_material.h"
#include "modeling/elastic/solid_grid.h"

namespace annulus {

/// A distributed force whose size is given, or is what moves the body by a given amount: q = Σ weight · displacement
/// (mm) and force f·weight at each node.
struct NodePull {
  struct Entry {
    std::size_t node = 0;
    Eigen::Vector3d weight = Eigen::Vector3d::Zero();
  };
  std::vector<Entry> entries;
  double force = 0.0;              ///< f, N, where no movement is asked for.
  std::optional<double> movement;  ///< q, mm.
};

/// A body of hexahedra, what holds it and what acts on it.
struct ElasticProblem {
  SolidGrid grid;
  ElasticMaterial material;
  std::vector<char> held;              ///< 1 for each of the 3·nodes components that is given.
  std::vector<Eigen::Vector3d> given;  ///< By node, mm: where held components go; others are not read.
  std::vector<NodePull> pulls{};
  std::vector<BandFibre> fibres{};
};

/// How rotations are treated.
enum class ElasticMethod {
  kLinear,       ///< They are small.
  kCorotational  ///< Every element is turned by its mean rotation: large rotations, strains up to some 10 %.
};

struct ElasticOptions {
  ElasticMethod method = ElasticMethod::kCorotational;
  int most_steps = 60;
  double tolerance =
      1e-8;  ///< Of forces left over at free nodes, over those at all (at least those of a strain of 1e-4).
};

/// The body at rest under what acts on it.
struct ElasticSolution {
  std::vector<Eigen::Vector3d> displacement;  ///< By node, mm.
  std::vector<Eigen::Matrix3d> rotation;      ///< By element (pile·(layers − 1) + level).
  double strain_energy = 0.0;                 ///< N·mm
  /// Potential energy (strain, bands, less the forces' work) at the first admissible shape and after every step, N·mm;
  /// never rises (but for rounding). With threads of given length: since they were last tightened.
  std::vector<double> potential;
  int steps = 0;
  double residual = 0.0;               ///< As ElasticOptions::tolerance.
  std::string termination;             ///< "converged", or why it stopped.
  std::vector<FibreState> fibres;      ///< As ElasticProblem::fibres.
  std::vector<double> pull_force;      ///< f of each pull, N.
  std::vector<double> pull_movement;   ///< q of each pull, mm.
  std::vector<Eigen::Vector3d> inner;  ///< By node: the elements' force, N; at free nodes what acts there.
};

/// Equilibrium by Newton's method with line search on the potential energy; where the tangent is not positive definite,
/// by Gauss and Newton's. The equations are solved by StackCholesky; movements asked
/// of pulls, and the length of threads, enter as updates of low rank (Woodbury). Deterministic, one thread. Fails on a
/// material out of range, on elements inside out, on a body that is not held, and on a stop request.
[[nodiscard]] Result<ElasticSolution> SolveElastic(const ElasticProblem& problem, const ElasticOptions& options,
                                                   const TaskContext& task);

}  // namespace annulus
