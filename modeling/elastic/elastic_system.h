#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "modeling/elastic/corotation.h"
#include "modeling/elastic/elastic_solver.h"
#include "modeling/elastic/stack_cholesky.h"

namespace annulus {

/// The body in one shape.
struct ElasticState {
  Eigen::VectorXd displacement;         ///< 3·nodes, mm.
  std::vector<TurnedElement> elements;  ///< As ElasticSolution::rotation.
  std::vector<FibreState> fibres;
  Eigen::VectorXd pull_movement;  ///< q by pull, mm.
  Eigen::VectorXd pull_force;     ///< f by pull, N.
  Eigen::VectorXd inner;          ///< Elements' forces, 3·nodes, N.
  Eigen::VectorXd gradient;       ///< Of the potential energy, 3·nodes, N; held components are not zero.
  double strain_energy = 0.0;     ///< N·mm
  double potential = 0.0;         ///< N·mm
};

/// A body's potential energy with its derivatives. Thread-bound.
class ElasticSystem {
 public:
  /// Borrows `problem`. Fails as SolveElastic.
  static Result<ElasticSystem> Make(const ElasticProblem& problem);

  [[nodiscard]] ElasticState At(const Eigen::VectorXd& displacement, ElasticMethod method) const;
  /// −(second derivatives)⁻¹ · gradient on free components, 0 on held ones; to 1e-3 (in energy) where threads couple
  /// nodes that are not neighbours. Nothing if they are not positive definite.
  [[nodiscard]] std::optional<Eigen::VectorXd> Step(const ElasticState& state, ElasticTangent tangent);
  /// The same with the second derivatives of the last call of Step, which must have given a step.
  [[nodiscard]] Eigen::VectorXd StepAgain(const ElasticState& state) const;
  /// Largest force left over free components, over the largest inner force at any node or, if that is more, that of a
  /// strain of 1e-4.
  [[nodiscard]] double Residual(const ElasticState& state) const;
  /// Given displacements of held components, 0 elsewhere.
  [[nodiscard]] const Eigen::VectorXd& given() const { return given_; }
  /// Stiffness against q (or a thread's length) if all its nodes move as their weights say, N/mm: an upper bound.
  [[nodiscard]] double StiffnessAlong(const Eigen::VectorXd& weight) const;
  [[nodiscard]] Eigen::VectorXd WeightOf(const NodePull& pull) const;
  /// ∂L/∂displacement of a thread.
  [[nodiscard]] Eigen::VectorXd WeightOf(const BandFibre& fibre, const FibreState& state) const;
  /// Where a thread's points are, mm.
  [[nodiscard]] std::vector<Eigen::Vector3d> PositionsOf(const BandFibre& fibre,
                                                         const Eigen::VectorXd& displacement) const;
  /// Rest length and stiffness of a thread may be changed while solving.
  [[nodiscard]] std::vector<BandFibre>& fibres() { return fibres_; }

 private:
  explicit ElasticSystem(const ElasticProblem& problem) : problem_(&problem), fibres_(problem.fibres) {}
  Status Prepare();
  class PileSums;
  class LooseSides;
  class WidelyCoupled;
  /// The skin nodes that a point lies between: lower and upper, the same if it lies on one.
  [[nodiscard]] std::array<std::size_t, 2> NodesOf(const FibrePoint& point) const;
  [[nodiscard]] Eigen::Vector3d DisplacementOf(const FibrePoint& point, const Eigen::VectorXd& displacement) const;
  /// Whether `b` is in the column right of `a`'s and one row of piles holds both; which.
  [[nodiscard]] std::optional<std::size_t> SharedRow(const FibrePoint& a, const FibrePoint& b) const;

  const ElasticProblem* problem_;
  std::vector<BandFibre> fibres_;
  std::vector<HexMatrix, Eigen::aligned_allocator<HexMatrix>> stiffness_;  ///< By element.
  std::optional<StackCholesky> factor_;                                    ///< Of the last step's equations.
  Eigen::VectorXd given_;
  double stack_area_ = 0.0;         ///< Of the first element, mm².
  Eigen::VectorXd pull_stiffness_;  ///< By pull whose movement is given: large; else 0.
};

}  // namespace annulus
