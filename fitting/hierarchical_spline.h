#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
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

/// A piece on which the surface is one bicubic polynomial of its level. It has 4 × 4 local B-spline coefficients (theta
/// fastest); on a `plain` leaf they are active coefficients themselves, elsewhere sums of several.
struct SplineLeaf {
  std::uint32_t theta_cell = 0;
  std::uint32_t z_cell = 0;
  std::uint32_t first = 0;  ///< Of its active coefficients in the spline's pool.
  std::uint32_t extraction_first = 0;
  std::uint16_t extraction_count = 0;
  std::uint16_t count = 0;  ///< Of its active coefficients, >= 1; 16 on a plain leaf.
  std::uint8_t level = 0;
  bool plain = false;
};

/// A weight of an active coefficient on a local one.
struct ExtractionEntry {
  double weight = 0.0;
  std::uint16_t local = 0;   ///< 0 … 15, theta fastest.
  std::uint16_t active = 0;  ///< In the order of HierarchicalSpline::Active.
};

/// Truncated hierarchical cubic B-splines (Giannelli, Jüttler, Speleers 2012) over periodic theta × clamped z: a coarse
/// tensor grid that is refined dyadically where asked. With one level it is the plain tensor product. Immutable.
class HierarchicalSpline {
 public:
  /// `theta_count` and `z_breakpoints` (uniform or not) are the coarsest level's; flags.size() + 1 levels.
  /// Requires theta_count >= 4 and flags of matching sizes; flags of cells outside their level's domain are dropped.
  HierarchicalSpline(std::size_t theta_count, const std::vector<double>& z_breakpoints, RefinementFlags flags);

  [[nodiscard]] const std::vector<SplineLevel>& levels() const { return levels_; }
  [[nodiscard]] const SplineLevel& finest() const { return levels_.back(); }
  [[nodiscard]] const RefinementFlags& flags() const { return flags_; }
  /// Number of active coefficients.
  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] const std::vector<SplineLeaf>& leaves() const { return leaves_; }
  /// The leaf that holds (theta, z).
  [[nodiscard]] std::size_t LeafAt(double theta, double z) const;
  /// The active coefficients that shape a leaf: in the order of its local coefficients if it is plain, else ascending.
  [[nodiscard]] std::span<const std::uint32_t> Active(const SplineLeaf& leaf) const {
    return std::span(active_).subspan(leaf.first, leaf.count);
  }
  /// The local coefficients as sums of active ones; none for a plain leaf.
  [[nodiscard]] std::span<const ExtractionEntry> Extraction(const SplineLeaf& leaf) const {
    return std::span(extraction_).subspan(leaf.extraction_first, leaf.extraction_count);
  }
  /// The local coefficients of a leaf.
  [[nodiscard]] Eigen::Matrix<double, 16, 1> Local(const SplineLeaf& leaf, const Eigen::VectorXd& active) const;

  /// The active coefficients that the radius at (theta, z) depends on, and by how much.
  [[nodiscard]] std::vector<CoefficientWeight> ActiveRow(double theta, double z) const;

  /// The surface with these active coefficients, as a tensor surface on the finest level: exact.
  [[nodiscard]] SplineSurface Surface(const Eigen::VectorXd& active) const;
  /// Derivatives with respect to the active coefficients of something whose derivatives with respect to the finest
  /// tensor surface's coefficients are given: the transpose of the linear map in Surface().
  [[nodiscard]] Eigen::VectorXd ActiveGradient(const Eigen::VectorXd& tensor_gradient) const;

 private:
  /// What became of the functions of one level: index of the active coefficient, or one of the two below.
  using Fates = std::vector<std::int32_t>;
  static constexpr std::int32_t kReplaced = -1;  ///< Finer functions stand for it; it has no weight here (truncation).
  static constexpr std::int32_t kCoarser = -2;   ///< Not within the level's domain: coarser functions go through it.

  class LeafBuilder;
  void DecideFates(std::size_t l, const std::vector<char>& domain);
  void BuildLeaves();

  std::vector<SplineLevel> levels_;
  RefinementFlags flags_;
  std::vector<Fates> fates_;  ///< One per level, theta fastest.
  std::size_t size_ = 0;
  std::vector<SplineLeaf> leaves_;
  std::vector<std::uint32_t> active_;
  std::vector<ExtractionEntry> extraction_;
  std::vector<std::uint32_t> leaf_of_fine_cell_;
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
