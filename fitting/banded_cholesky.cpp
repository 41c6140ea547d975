#include "fitting/banded_cholesky.h"

#include <algorithm>

#include "fitting/front_kernels.h"

namespace annulus {
namespace {

constexpr std::size_t kBlocks = TensorMatrix::kReach + 1;

using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

}  // namespace

BandedCholesky::BandedCholesky(std::size_t block, std::size_t size)
    : block_(block),
      size_(size),
      // The spare rows between two columns take what the kernel writes beside a front; they stay out of the band.
      stride_(kBlocks * block + 2 * kFrontLanes),
      band_(size * stride_ + size + 2 * kFrontLanes, 0.0) {}

std::size_t BandedCholesky::Reach(std::size_t first) const { return std::min(kBlocks * block_, size_ - first); }

std::optional<BandedCholesky> BandedCholesky::Factor(const TensorMatrix& matrix) {
  BandedCholesky l(matrix.theta_count(), matrix.size());
  const std::size_t width = matrix.theta_count();
  for (std::ptrdiff_t dj = 0; dj <= TensorMatrix::kReach; ++dj) {
    for (std::ptrdiff_t di = dj == 0 ? 0 : -TensorMatrix::kReach; di <= TensorMatrix::kReach; ++di) {
      const double* entries = matrix.Coupling(di, dj);
      for (std::size_t j = 0; j + static_cast<std::size_t>(dj) < matrix.z_count(); ++j) {
        const std::size_t other_row = (j + static_cast<std::size_t>(dj)) * width;
        for (std::size_t i = 0; i < width; ++i) {
          const std::size_t a = j * width + i;
          const std::size_t b = other_row + (i + width + static_cast<std::size_t>(di)) % width;
          l.At(std::max(a, b), std::min(a, b)) = entries[a];
        }
      }
    }
  }
  for (std::size_t first = 0; first < l.size_; first += width) {
    const std::size_t next = first + width;
    double* rest = next < l.size_ ? &l.At(next, next) : nullptr;
    if (!EliminateFront(&l.At(first, first), l.stride_, l.Reach(first), width, rest, l.stride_)) return std::nullopt;
  }
  return l;
}

Eigen::VectorXd BandedCholesky::Solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x = b;
  const auto own = static_cast<Eigen::Index>(block_);
  const auto panel_at = [this](std::size_t first) {
    return Panel(&band_[first * stride_ + first], static_cast<Eigen::Index>(Reach(first)),
                 static_cast<Eigen::Index>(block_), Eigen::OuterStride<>(static_cast<Eigen::Index>(stride_)));
  };
  for (std::size_t first = 0; first < size_; first += block_) {
    const Panel panel = panel_at(first);
    auto mine = x.segment(static_cast<Eigen::Index>(first), own);
    auto rest = x.segment(static_cast<Eigen::Index>(first) + own, panel.rows() - own);
    panel.topRows(own).triangularView<Eigen::Lower>().solveInPlace(mine);
    rest.noalias() -= panel.bottomRows(rest.size()) * mine;
  }
  for (std::size_t first = size_; first > 0;) {
    first -= block_;
    const Panel panel = panel_at(first);
    auto mine = x.segment(static_cast<Eigen::Index>(first), own);
    const auto rest = x.segment(static_cast<Eigen::Index>(first) + own, panel.rows() - own);
    mine.noalias() -= panel.bottomRows(rest.size()).transpose() * rest;
    panel.topRows(own).transpose().triangularView<Eigen::Upper>().solveInPlace(mine);
  }
  return x;
}

}  // namespace annulus
