#include "fitting/tensor_matrix.h"

#include <algorithm>
#include <type_traits>

#include "base/ensure.h"
#include "fitting/front_kernels.h"

namespace annulus {
namespace {

constexpr std::size_t kVectors = 25;
static_assert(std::is_same_v<TensorForm, std::array<double, 160>>);

}  // namespace

TensorMatrix::TensorMatrix(std::size_t theta_count, std::size_t z_count)
    : theta_count_(theta_count), z_count_(z_count), entries_(kVectors * theta_count * z_count, 0.0) {
  ENSURE(theta_count >= 8 && z_count >= 4, "a tensor matrix is wider than its couplings");
}

void TensorMatrix::AddForm(std::size_t theta_interval, std::size_t z_interval, const std::array<double, 160>& form) {
  std::array<std::size_t, 4> column{};
  for (std::size_t p = 0; p < 4; ++p) column[p] = (theta_interval + theta_count_ - 1 + p) % theta_count_;
  const double* block = form.data();
  for (std::size_t b = 0; b < 4; ++b) {
    for (std::size_t a = 0; a <= b; ++a, block += 16) {
      const std::size_t row = (z_interval + a) * theta_count_;
      for (std::size_t q = 0; q < 4; ++q) {
        for (std::size_t p = 0; p < (a == b ? q + 1 : 4); ++p) {
          const auto di = static_cast<std::ptrdiff_t>(q) - static_cast<std::ptrdiff_t>(p);
          entries_[At(di, static_cast<std::ptrdiff_t>(b - a)) + row + column[p]] += block[4 * q + p];
        }
      }
    }
  }
}

void TensorMatrix::AddProduct(double factor, const Eigen::MatrixXd& z, const Eigen::MatrixXd& theta) {
  const auto width = static_cast<Eigen::Index>(theta_count_);
  const auto height = static_cast<Eigen::Index>(z_count_);
  Eigen::ArrayXd across(width);
  for (std::ptrdiff_t dj = 0; dj <= kReach; ++dj) {
    for (std::ptrdiff_t di = dj == 0 ? 0 : -kReach; di <= kReach; ++di) {
      for (Eigen::Index i = 0; i < width; ++i) across[i] = theta(i, (i + di + width) % width);
      Eigen::Map<Eigen::ArrayXXd> target(&entries_[At(di, dj)], width, height);
      for (Eigen::Index j = 0; j + dj < height; ++j) target.col(j) += (factor * z(j, j + dj)) * across;
    }
  }
}

void TensorMatrix::AddToDiagonal(double value) {
  for (std::size_t k = 0; k < size(); ++k) entries_[k] += value;
}

void TensorMatrix::Add(const TensorMatrix& other, double factor) {
  ENSURE(other.theta_count_ == theta_count_ && other.z_count_ == z_count_, "same basis");
  const auto n = static_cast<Eigen::Index>(entries_.size());
  Eigen::Map<Eigen::ArrayXd>(entries_.data(), n) += factor * Eigen::Map<const Eigen::ArrayXd>(other.entries_.data(), n);
}

double TensorMatrix::MeanDiagonal() const {
  return Eigen::Map<const Eigen::ArrayXd>(entries_.data(), static_cast<Eigen::Index>(size())).mean();
}

Eigen::VectorXd TensorMatrix::operator*(const Eigen::VectorXd& x) const {
  // Both vectors with three more columns on either side, so that the way around needs no wrapping inside.
  const auto width = static_cast<Eigen::Index>(theta_count_);
  const auto height = static_cast<Eigen::Index>(z_count_);
  const Eigen::Map<const Eigen::ArrayXXd> plain(x.data(), width, height);
  Eigen::ArrayXXd wide(width + 2 * kReach, height);
  wide.topRows(kReach) = plain.bottomRows(kReach);
  wide.middleRows(kReach, width) = plain;
  wide.bottomRows(kReach) = plain.topRows(kReach);
  Eigen::ArrayXXd sum = Eigen::ArrayXXd::Zero(width + 2 * kReach, height);
  for (std::ptrdiff_t dj = 0; dj <= kReach; ++dj) {
    for (std::ptrdiff_t di = dj == 0 ? 0 : -kReach; di <= kReach; ++di) {
      const Eigen::Map<const Eigen::ArrayXXd> entry(&entries_[At(di, dj)], width, height);
      const bool diagonal = di == 0 && dj == 0;
      for (Eigen::Index j = 0; j + dj < height; ++j) {
        sum.col(j).segment(kReach, width) += entry.col(j) * wide.col(j + dj).segment(kReach + di, width);
        if (!diagonal) sum.col(j + dj).segment(kReach + di, width) += entry.col(j) * plain.col(j);
      }
    }
  }
  Eigen::VectorXd product(x.size());
  Eigen::Map<Eigen::ArrayXXd> folded(product.data(), width, height);
  folded = sum.middleRows(kReach, width);
  folded.bottomRows(kReach) += sum.topRows(kReach);
  folded.topRows(kReach) += sum.bottomRows(kReach);
  return product;
}

Eigen::SparseMatrix<double> TensorMatrix::UpperTriangle() const {
  const auto n = static_cast<Eigen::Index>(size());
  Eigen::SparseMatrix<double> upper(n, n);
  upper.reserve(static_cast<Eigen::Index>(kVectors * size()));
  const auto width = static_cast<std::ptrdiff_t>(theta_count_);
  for (std::ptrdiff_t j = 0; j < static_cast<std::ptrdiff_t>(z_count_); ++j) {
    for (std::ptrdiff_t i = 0; i < width; ++i) {
      upper.startVec(j * width + i);
      for (std::ptrdiff_t dj = std::min(j, kReach); dj >= 0; --dj) {
        // Row (i − di) of level j − dj, in ascending order: first what has wrapped around, then the rest.
        const auto insert = [&](std::ptrdiff_t di) {
          const std::ptrdiff_t row = (i - di + width) % width;
          if (dj == 0 && row > i) return;
          const double value = dj == 0 && di < 0
                                   ? entries_[At(-di, 0) + static_cast<std::size_t>(j * width + i)]
                                   : entries_[At(di, dj) + static_cast<std::size_t>((j - dj) * width + row)];
          upper.insertBackByOuterInner(j * width + i, (j - dj) * width + row) = value;
        };
        for (std::ptrdiff_t di = kReach; di >= -kReach; --di) {
          if (i - di >= width) insert(di);
        }
        for (std::ptrdiff_t di = kReach; di >= -kReach; --di) {
          if (i - di >= 0 && i - di < width) insert(di);
        }
        for (std::ptrdiff_t di = kReach; di >= -kReach; --di) {
          if (i - di < 0) insert(di);
        }
      }
    }
  }
  upper.finalize();
  return upper;
}

}  // namespace annulus
