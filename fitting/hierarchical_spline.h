#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "fitting/bspline_basis.h"
#include "fitting/covariance.h"
#include "fitting/spline_surface.h"

namespace annulus {

/// Knots of one level.
struct SplineLevel {
  PeriodicCubicBasis theta;
  ClampedCubicBasis z;

  [[nodiscard]] std::size_t theta_cells() const { return theta.count(); }
  [[nodiscard]] std::size_t z_cells() const { return z.breakpoints().size() - 1; }
};

/// Where the surface is refined: for every level but the last, which of its cells are split into 2 × 2 cells of the
/// next. Cell (i, j) at j·theta_cells + i. A cell may be split only where its own level lives.
using RefinementFlags = std::vector<std::vector<char>>;

/// A piece on which the surface is one bicubic polynomial of its level, and the active coefficients that shape it:
/// local B-spline coefficients (4 × 4, theta fastest) = extractionᵀ · active coefficients.
struct SplineLeaf {
  std::uint8_t level = 0;
  std::uint32_t theta_cell = 0;
  std::uint32_t z_cell = 0;
  std::vector<std::uint32_t> active;                     ///< Indices of active coefficients, ascending.
  Eigen::Matrix<double, Eigen::Dynamic, 16> extraction;  ///< One row per entry of `active`.
};

/// Truncated hierarchical cubic B-splines (Giannelli, Jüttler, Speleers 2012) over periodic theta × clamped z: a coarse
/// tensor grid that is refined dyadically where asked. With one level it is the plain tensor product. Immutable.
class HierarchicalSpline {
 public:
  using SparseRow = std::vector<std::pair<std::uint32_t, double>>;  ///< Active index and weight.
  using Rows = std::vector<SparseRow>;                              ///< One per function of a level, theta fastest.

  /// `theta_count` and `z_breakpoints` (uniform or not) are the coarsest level's; flags.size() + 1 levels.
  /// Requires theta_count >= 4 and flags of matching sizes; flags of cells outside their level's domain are dropped.
  HierarchicalSpline(std::size_t theta_count, const std::vector<double>& z_breakpoints, RefinementFlags flags);

  [[nodiscard]] const std::vector<SplineLevel>& levels() const { return levels_; }
  [[nodiscard]] const SplineLevel& finest() const { return levels_.back(); }
  [[nodiscard]] const RefinementFlags& flags() const { return flags_; }
  /// Number of active coefficients.
  [[nodiscard]] std::size_t size() const { return size_; }

  /// The leaf that holds (theta, z).
  [[nodiscard]] std::size_t LeafAt(double theta, double z) const;
  [[nodiscard]] const std::vector<SplineLeaf>& leaves() const { return leaves_; }
  /// The active coefficients that the radius at (theta, z) depends on, and by how much.
  [[nodiscard]] std::vector<CoefficientWeight> ActiveRow(double theta, double z) const;

  /// The finest tensor grid's coefficients as a linear map of the active ones: exact.
  [[nodiscard]] const Eigen::SparseMatrix<double, Eigen::RowMajor>& fine_from_active() const {
    return fine_from_active_;
  }
  /// The surface with these active coefficients, as a tensor surface on the finest level.
  [[nodiscard]] SplineSurface Surface(const Eigen::VectorXd& active) const;

  /// Flags that also let the next level act at every marked place: `marks` are cells of the finest level (theta
  /// fastest). Splits all cells of `level` under the functions of level + 1 that do not vanish there.
  [[nodiscard]] RefinementFlags WithMarks(std::size_t level, const std::vector<char>& marks) const;

 private:
  /// Weights of the active coefficients on every function of a level; gives the level's active functions their indices.
  Rows RowsOfLevel(std::size_t l, const std::vector<char>& domain, const std::vector<Rows>& coarser);
  void BuildLeaves(const std::vector<Rows>& rows);

  std::vector<SplineLevel> levels_;
  RefinementFlags flags_;
  std::size_t size_ = 0;
  std::vector<SplineLeaf> leaves_;
  std::vector<std::uint32_t> leaf_of_fine_cell_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> fine_from_active_;
};

/// The weights with which splines over `coarse` are sums of splines over `fine`: one row per fine spline. Every
/// breakpoint of `coarse` must be one of `fine` (Oslo algorithm: Cohen, Lyche, Riesenfeld 1980).
struct RefinementEntry {
  std::size_t coarse = 0;
  double weight = 0.0;
};
[[nodiscard]] std::vector<std::vector<RefinementEntry>> RefinementWeights(const ClampedCubicBasis& coarse,
                                                                          const ClampedCubicBasis& fine);

}  // namespace annulus
