#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "modeling/elastic/stack_tree.h"

namespace annulus {

/// Cholesky factor A = PᵀLLᵀP of a symmetric positive definite matrix that is a sum of dense matrices, one per pile of
/// elements (multifrontal method: Duff, Reid 1983; the elimination of a front is fitting's). No sparse matrix is ever
/// formed. Takes a few 100 numbers per unknown.
class StackCholesky {
 public:
  /// Gives the matrix of a pile: symmetric, (12·layers)², column-major, its four stacks one after the other
  /// (GridShape::StacksOf), each with its 3·layers components; valid until the next call. Held components are skipped.
  using PileMatrix = std::function<const double*(std::size_t pile)>;

  /// Nothing if the sum is not positive definite.
  [[nodiscard]] static std::optional<StackCholesky> Factor(std::shared_ptr<const StackTree> tree,
                                                           const PileMatrix& pile_matrix);

  /// A⁻¹ B for right sides of 3·nodes rows; rows of held components are not read and become zero.
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;
  /// Numbers stored.
  [[nodiscard]] std::size_t stored() const { return panels_.size(); }

 private:
  explicit StackCholesky(std::shared_ptr<const StackTree> tree);  ///< All columns zero.
  [[nodiscard]] bool Eliminate(const PileMatrix& pile_matrix);

  std::shared_ptr<const StackTree> tree_;  ///< Shared with the factors of other matrices of the same grid.
  std::vector<double> panels_;             ///< Own columns of every front, column-major.
  std::vector<std::size_t> panel_first_;
};

}  // namespace annulus
