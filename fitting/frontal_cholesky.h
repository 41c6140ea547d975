#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "fitting/elimination_tree.h"
#include "fitting/front_store.h"

namespace annulus {

/// Cholesky factor A = PᵀLLᵀP of a sparse symmetric positive definite matrix that is a sum of small dense matrices, one
/// per leaf of a hierarchical spline (multifrontal method: Duff, Reid 1983). No sparse matrix is ever formed: the
/// leaves' matrices go straight into the dense fronts of the elimination tree.
class FrontalCholesky {
 public:
  /// A leaf's matrix over its active coefficients (HierarchicalSpline::Active): symmetric, both triangles,
  /// column-major.
  struct LeafView {
    const double* data = nullptr;
    std::size_t stride = 0;
  };
  /// Gives the matrix of a leaf, valid until the next call.
  using LeafMatrix = std::function<LeafView(std::size_t leaf)>;

  /// Factors Σ leaf matrices + ridge·I. Nothing if the sum is not positive definite. Borrows `tree` and the basis only
  /// during the call.
  [[nodiscard]] static std::optional<FrontalCholesky> Factor(std::shared_ptr<const EliminationTree> tree,
                                                             const HierarchicalSpline& basis,
                                                             const LeafMatrix& leaf_matrix, double ridge);
  /// Factors a matrix that is already summed, by its upper triangle. Nothing if it is not positive definite or couples
  /// coefficients that share no leaf.
  [[nodiscard]] static std::optional<FrontalCholesky> Factor(std::shared_ptr<const EliminationTree> tree,
                                                             const Eigen::SparseMatrix<double>& upper);

  [[nodiscard]] Eigen::Index size() const { return size_; }
  /// A⁻¹ b.
  [[nodiscard]] Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;
  /// A⁻¹ B for four right sides at once, in little more time than one.
  using FourColumns = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
  [[nodiscard]] FourColumns Solve(const FourColumns& b) const;
  /// L⁻¹ P b: in the order of elimination.
  [[nodiscard]] Eigen::VectorXd SolveLower(const Eigen::VectorXd& b) const;
  [[nodiscard]] FourColumns SolveLower(const FourColumns& b) const;
  /// Pᵀ L⁻ᵀ y, for y in the order of elimination.
  [[nodiscard]] Eigen::VectorXd SolveUpper(const Eigen::VectorXd& y) const;
  [[nodiscard]] const std::shared_ptr<const EliminationTree>& shared_tree() const { return tree_; }
  /// The own columns of a node's front: rows are its own, then its boundary coefficients; lower part.
  using Columns = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  [[nodiscard]] Columns ColumnsOf(std::size_t node) const;
  /// Numbers stored.
  [[nodiscard]] std::size_t stored() const { return panels_.stored(); }

 private:
  explicit FrontalCholesky(std::shared_ptr<const EliminationTree> tree);  ///< All columns zero.
  /// Eliminates node by node; `add_leaves(node, front)` is called for nodes without children.
  template <class AddLeaves>
  [[nodiscard]] bool Eliminate(AddLeaves add_leaves);
  /// One right side or four, by rows.
  template <class Right>
  [[nodiscard]] Right Lower(const Right& b) const;
  template <class Right>
  [[nodiscard]] Right Upper(const Right& y) const;

  std::shared_ptr<const EliminationTree> tree_;  ///< Shared with the factors of other weights of the same basis.
  FrontPanels panels_;
  Eigen::Index size_ = 0;
  Eigen::Index largest_boundary_ = 0;
};

}  // namespace annulus
