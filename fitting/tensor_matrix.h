#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <vector>

namespace annulus {

/// Symmetric matrix over the coefficients of one periodic-by-clamped cubic tensor spline: coefficient (i, j), i of
/// `theta_count` around and j of `z_count` up, is unknown j·theta_count + i; two couple when they are at most three
/// apart both ways (they share an interval). Stored by distance: 25 vectors, half of the 49 that are not zero.
class TensorMatrix {
 public:
  static constexpr std::ptrdiff_t kReach = 3;

  /// Zero. Requires theta_count >= 8, so that the two ways around are not confused, and z_count >= 4.
  TensorMatrix(std::size_t theta_count, std::size_t z_count);

  [[nodiscard]] std::size_t theta_count() const { return theta_count_; }
  [[nodiscard]] std::size_t z_count() const { return z_count_; }
  [[nodiscard]] std::size_t size() const { return theta_count_ * z_count_; }

  /// Entries ((i, j), (i + di mod theta_count, j + dj)) by unknown (i, j): di in −3 … 3, dj in 0 … 3, di >= 0 if dj is
  /// 0. Those with j + dj >= z_count do not exist and are zero.
  [[nodiscard]] const double* Coupling(std::ptrdiff_t di, std::ptrdiff_t dj) const { return &entries_[At(di, dj)]; }

  /// Adds a form over the 4 × 4 coefficients that act on one cell of the knots (TensorForm of front_kernels.h).
  void AddForm(std::size_t theta_interval, std::size_t z_interval, const std::array<double, 160>& form);
  /// Adds factor · z ⊗ theta, where `z` is symmetric with entries up to three from the diagonal, `theta` likewise and
  /// cyclic.
  void AddProduct(double factor, const Eigen::MatrixXd& z, const Eigen::MatrixXd& theta);
  void AddToDiagonal(double value);
  /// this += factor · other (same sizes).
  void Add(const TensorMatrix& other, double factor);

  [[nodiscard]] double MeanDiagonal() const;
  [[nodiscard]] Eigen::VectorXd operator*(const Eigen::VectorXd& x) const;
  /// The upper triangle; every pair that couples has an entry, zero or not.
  [[nodiscard]] Eigen::SparseMatrix<double> UpperTriangle() const;

 private:
  [[nodiscard]] std::size_t At(std::ptrdiff_t di, std::ptrdiff_t dj) const {
    const std::ptrdiff_t vector = dj == 0 ? di : 7 * dj + di;  // 0 … 3, 4 … 10, 11 … 17, 18 … 24
    return static_cast<std::size_t>(vector) * size();
  }

  std::size_t theta_count_;
  std::size_t z_count_;
  std::vector<double> entries_;
};

}  // namespace annulus
