#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>

#include "fitting/front_store.h"
#include "modeling/elastic/stack_tree.h"

namespace annulus {

/// Cholesky factor A = PᵀLLᵀP of a symmetric positive definite matrix that is a sum of dense matrices, one per pile of
/// elements (multifrontal method: Duff, Reid 1983; the fronts are fitting's). No sparse matrix is ever formed. Takes a
/// few 100 numbers per unknown, which are kept for the next matrix of the same grid: memory that the system has to give
/// anew costs as much as the elimination.
class StackCholesky {
 public:
  /// Gives the matrix of a pile: symmetric, (12·layers)², column-major, its four stacks one after the other
  /// (GridShape::StacksOf), each with its 3·layers components; valid until the next call. Held components are skipped.
  using PileMatrix = std::function<const double*(std::size_t pile)>;

  explicit StackCholesky(std::shared_ptr<const StackTree> tree);
  /// False if the sum is not positive definite: there is no factor then.
  [[nodiscard]] bool Factor(const PileMatrix& pile_matrix);

  /// A⁻¹ b for 3·nodes rows; those of held components are not read and become zero. Needs a factor.
  [[nodiscard]] Eigen::VectorXd Solve(const Eigen::VectorXd& right) const;
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;
  /// Numbers stored.
  [[nodiscard]] std::size_t stored() const { return panels_.stored(); }

 private:
  template <class Right>
  [[nodiscard]] Right SolveFor(const Right& right) const;

  std::shared_ptr<const StackTree> tree_;  ///< Shared with the factors of other matrices of the same grid.
  FrontPanels panels_;
  FrontStack waiting_;
};

}  // namespace annulus
