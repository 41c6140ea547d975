#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fitting/covariance.h"
#include "fitting/frontal_cholesky.h"

namespace annulus {

/// The entries of A⁻¹ on the pattern of a factor's fronts, by Takahashi's recursion (Takahashi, Fagan, Chin 1973) over
/// whole fronts: with own columns L_o, boundary rows L_b and X = L_b L_o⁻¹, from the root to the leaves,
///   Z_bo = −Z_bb X,  Z_oo = L_o⁻ᵀ L_o⁻¹ − Xᵀ Z_bo,
/// where Z_bb lies in the parent's front. Immutable.
class FrontalInverse {
 public:
  explicit FrontalInverse(const FrontalCholesky& factor);

  /// gᵀA⁻¹g; nothing if two entries of the gradient lie in no common front.
  [[nodiscard]] std::optional<double> Variance(std::span<const CoefficientWeight> gradient) const;

 private:
  std::shared_ptr<const EliminationTree> tree_;
  std::vector<double> panels_;  ///< Own columns of every front, all its rows, column-major without gaps.
  std::vector<std::size_t> panel_first_;
};

}  // namespace annulus
