#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "fitting/tensor_matrix.h"

namespace annulus {

/// Cholesky factor A = LLᵀ of a TensorMatrix as a band matrix: one row of coefficients around is a block that couples
/// to the next three, so that the half band is four blocks wide and dense (the way around fills it). Takes size ·
/// (4·theta_count + 16) · 8 bytes.
class BandedCholesky {
 public:
  /// Nothing if the matrix is not positive definite.
  [[nodiscard]] static std::optional<BandedCholesky> Factor(const TensorMatrix& matrix);

  /// A⁻¹ b.
  [[nodiscard]] Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;

 private:
  BandedCholesky(std::size_t block, std::size_t size);

  /// Rows that the block of columns from `first` reaches, itself included.
  [[nodiscard]] std::size_t Reach(std::size_t first) const;
  /// Entry (row, column) of L, for row >= column.
  [[nodiscard]] double& At(std::size_t row, std::size_t column) { return band_[column * stride_ + row]; }

  std::size_t block_;
  std::size_t size_;
  std::size_t stride_;  ///< From column to column: any block of the band is a dense matrix of this stride.
  std::vector<double> band_;
};

}  // namespace annulus
