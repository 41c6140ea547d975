#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// Symmetric matrix over the coefficients of a tensor-product cubic spline surface, periodic in theta: every row
/// couples only with coefficients at most 3 away in either direction. Stored as that stencil, so that adding a sample
/// is 136 additions without a search.
class StencilMatrix {
 public:
  /// All zero. theta_count >= 7 (below, cyclic neighbours would coincide), z_count >= 4.
  StencilMatrix(std::size_t theta_count, std::size_t z_count);

  [[nodiscard]] std::size_t size() const { return theta_count_ * z_count_; }

  /// Adds weight · bᵀb, with b the sparse row that is outer(z.*, theta.*) of two basis evaluations.
  void AddOuter(const CubicBasis& theta, const std::array<double, 4>& theta_weights, const CubicBasis& z,
                const std::array<double, 4>& z_weights, double weight);

  /// this += factor · other (same shape).
  void Add(const StencilMatrix& other, double factor);
  /// Adds `value` to every diagonal entry.
  void AddDiagonal(double value);

  [[nodiscard]] double MeanDiagonal() const;

  /// The upper triangle as a compressed sparse matrix.
  [[nodiscard]] Eigen::SparseMatrix<double> UpperTriangle() const;

 private:
  static constexpr std::size_t kReach = 3;
  static constexpr std::size_t kStencil = (kReach + 1) * (2 * kReach + 1);
  std::size_t theta_count_;
  std::size_t z_count_;
  std::vector<double> values_;  ///< [j][i][dj 0…3][di -3…3]
};

}  // namespace annulus
