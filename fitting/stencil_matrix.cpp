#include "fitting/stencil_matrix.h"

#include <algorithm>

#include "base/ensure.h"

namespace annulus {

StencilMatrix::StencilMatrix(std::size_t theta_count, std::size_t z_count)
    : theta_count_(theta_count), z_count_(z_count), values_(theta_count * z_count * kStencil, 0.0) {
  ENSURE(theta_count >= 2 * kReach + 1 && z_count >= kReach + 1, "the stencil fits the grid");
}

void StencilMatrix::AddOuter(const CubicBasis& theta, const std::array<double, 4>& theta_weights, const CubicBasis& z,
                             const std::array<double, 4>& z_weights, double weight) {
  std::array<double, 4> theta_weighted{};
  for (std::size_t i = 0; i < 4; ++i) theta_weighted[i] = weight * theta_weights[i];
  for (std::size_t j1 = 0; j1 < 4; ++j1) {
    for (std::size_t j2 = j1; j2 < 4; ++j2) {
      const double z_product = z_weights[j1] * z_weights[j2];
      for (std::size_t i1 = 0; i1 < 4; ++i1) {
        // (j1, i1) with (j2, i2): di = i2 - i1 in -3 … 3, stored at offset di + 3 of the stencil's row j2 - j1.
        double* row =
            &values_[((z.index[j1] * theta_count_ + theta.index[i1]) * (kReach + 1) + (j2 - j1)) * (2 * kReach + 1)];
        const double left = z_product * theta_weighted[i1];
        for (std::size_t i2 = 0; i2 < 4; ++i2) row[i2 + kReach - i1] += left * theta_weights[i2];
      }
    }
  }
}

void StencilMatrix::Add(const StencilMatrix& other, double factor) {
  ENSURE(other.values_.size() == values_.size(), "same shape");
  for (std::size_t k = 0; k < values_.size(); ++k) values_[k] += factor * other.values_[k];
}

void StencilMatrix::AddDiagonal(double value) {
  for (std::size_t row = 0; row < size(); ++row) values_[row * kStencil + kReach] += value;
}

double StencilMatrix::MeanDiagonal() const {
  double sum = 0.0;
  for (std::size_t row = 0; row < size(); ++row) sum += values_[row * kStencil + kReach];
  return sum / static_cast<double>(size());
}

Eigen::SparseMatrix<double> StencilMatrix::UpperTriangle() const {
  using Triplet = Eigen::Triplet<double>;
  std::vector<Triplet> triplets;
  triplets.reserve(values_.size());
  for (std::size_t j = 0; j < z_count_; ++j) {
    for (std::size_t i = 0; i < theta_count_; ++i) {
      const std::size_t row = j * theta_count_ + i;
      for (std::size_t dj = 0; dj <= kReach && j + dj < z_count_; ++dj) {
        for (std::size_t d = 0; d < 2 * kReach + 1; ++d) {
          if (dj == 0 && d < kReach) continue;  // the mirror image of a stored entry
          const std::size_t column = (j + dj) * theta_count_ + (i + theta_count_ + d - kReach) % theta_count_;
          const double value = values_[row * kStencil + dj * (2 * kReach + 1) + d];
          if (value != 0.0) {
            triplets.emplace_back(static_cast<int>(std::min(row, column)), static_cast<int>(std::max(row, column)),
                                  value);
          }
        }
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(size());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

}  // namespace annulus
