#include "fitting/hierarchical_spline.h"

#include <algorithm>
#include <array>
#include <map>

#include "base/ensure.h"

namespace annulus {
namespace {

using SparseRow = HierarchicalSpline::SparseRow;
using Rows = HierarchicalSpline::Rows;

std::vector<double> Halved(const std::vector<double>& breakpoints) {
  std::vector<double> fine;
  for (std::size_t k = 0; k + 1 < breakpoints.size(); ++k) {
    fine.push_back(breakpoints[k]);
    fine.push_back(0.5 * (breakpoints[k] + breakpoints[k + 1]));
  }
  fine.push_back(breakpoints.back());
  return fine;
}

/// Cells under theta spline i of n: i - 2 … i + 1.
std::array<std::size_t, 4> ThetaSupport(std::size_t i, std::size_t n) {
  return {(i + n - 2) % n, (i + n - 1) % n, i, (i + 1) % n};
}

/// Cells under z spline j: j - 3 … j within the range.
struct CellRange {
  std::size_t first = 0;
  std::size_t last = 0;  ///< Included.
};
CellRange ZSupport(std::size_t j, std::size_t cells) { return {j >= 3 ? j - 3 : 0, std::min(j, cells - 1)}; }

/// True if every cell of `level` under spline (i, j) has `flag` set.
bool AllUnder(const SplineLevel& level, const std::vector<char>& flag, std::size_t i, std::size_t j) {
  const CellRange range = ZSupport(j, level.z_cells());
  for (std::size_t cell = range.first; cell <= range.last; ++cell) {
    for (const std::size_t column : ThetaSupport(i, level.theta_cells())) {
      if (flag[cell * level.theta_cells() + column] == 0) return false;
    }
  }
  return true;
}

/// Flags of a level spread over the cells of the next one.
std::vector<char> Children(const SplineLevel& level, const std::vector<char>& flag) {
  const std::size_t width = level.theta_cells();
  std::vector<char> fine(4 * flag.size());
  for (std::size_t j = 0; j < 2 * level.z_cells(); ++j) {
    for (std::size_t i = 0; i < 2 * width; ++i) fine[j * 2 * width + i] = flag[(j / 2) * width + i / 2];
  }
  return fine;
}

void AddScaled(SparseRow& sum, const SparseRow& row, double factor) {
  for (const auto& [index, weight] : row) sum.emplace_back(index, factor * weight);
}

/// Sorts by index and adds up equal ones.
void Compress(SparseRow& row) {
  std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (kept > 0 && row[kept - 1].first == row[k].first) {
      row[kept - 1].second += row[k].second;
    } else {
      row[kept++] = row[k];
    }
  }
  row.resize(kept);
}

/// Weights of periodic subdivision: fine spline 2k (centred on coarse knot k) and 2k + 1 (between).
std::vector<RefinementEntry> PeriodicWeights(std::size_t fine, std::size_t coarse_count) {
  const std::size_t k = fine / 2;
  if (fine % 2 == 0) {
    return {{(k + coarse_count - 1) % coarse_count, 0.125}, {k, 0.75}, {(k + 1) % coarse_count, 0.125}};
  }
  return {{k, 0.5}, {(k + 1) % coarse_count, 0.5}};
}

}  // namespace

std::vector<std::vector<RefinementEntry>> RefinementWeights(const ClampedCubicBasis& coarse,
                                                            const ClampedCubicBasis& fine) {
  const auto full_knots = [](const ClampedCubicBasis& basis) {
    std::vector<double> knots(3, basis.min());
    knots.insert(knots.end(), basis.breakpoints().begin(), basis.breakpoints().end());
    knots.insert(knots.end(), 3, basis.max());
    return knots;
  };
  const std::vector<double> t = full_knots(coarse);
  const std::vector<double> tau = full_knots(fine);
  std::vector<std::vector<RefinementEntry>> weights(fine.count());
  for (std::size_t k = 0; k < fine.count(); ++k) {
    // The coarse interval t[m] <= tau[k] < t[m+1].
    const auto above = std::upper_bound(t.begin() + 4, t.end() - 4, tau[k]);
    const std::size_t m = static_cast<std::size_t>(above - t.begin()) - 1;
    // Discrete B-splines alpha_{m-order+1+i} of rising order, by the recurrence with tau[k + order - 1].
    std::array<double, 4> alpha{1.0, 0.0, 0.0, 0.0};
    for (std::size_t order = 2; order <= 4; ++order) {
      std::array<double, 4> next{};
      const double x = tau[k + order - 1];
      for (std::size_t i = 0; i < order; ++i) {
        const std::size_t j = m + 1 + i - order;  // coarse spline
        double value = 0.0;
        if (i > 0) value += (x - t[j]) / (t[j + order - 1] - t[j]) * alpha[i - 1];
        if (i + 1 < order) value += (t[j + order] - x) / (t[j + order] - t[j + 1]) * alpha[i];
        next[i] = value;
      }
      alpha = next;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      if (alpha[i] != 0.0) weights[k].push_back({m - 3 + i, alpha[i]});
    }
  }
  return weights;
}

HierarchicalSpline::HierarchicalSpline(std::size_t theta_count, const std::vector<double>& z_breakpoints,
                                       RefinementFlags flags)
    : flags_(std::move(flags)) {
  levels_.push_back({PeriodicCubicBasis(theta_count), ClampedCubicBasis(z_breakpoints)});
  std::vector<std::vector<char>> domain;  // of every level, as flags over its own cells; nested by force
  domain.emplace_back(levels_[0].theta_cells() * levels_[0].z_cells(), char{1});
  for (std::size_t l = 0; l < flags_.size(); ++l) {
    ENSURE(flags_[l].size() == domain[l].size(), "one flag per cell");
    for (std::size_t k = 0; k < flags_[l].size(); ++k) flags_[l][k] = flags_[l][k] != 0 && domain[l][k] != 0 ? 1 : 0;
    domain.push_back(Children(levels_[l], flags_[l]));
    SplineLevel finer{PeriodicCubicBasis(2 * levels_[l].theta_cells()),
                      ClampedCubicBasis(Halved(levels_[l].z.breakpoints()))};
    levels_.push_back(std::move(finer));
  }

  std::vector<Rows> rows;
  for (std::size_t l = 0; l < levels_.size(); ++l) rows.push_back(RowsOfLevel(l, domain[l], rows));
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t k = 0; k < rows.back().size(); ++k) {
    for (const auto& [index, weight] : rows.back()[k]) {
      triplets.emplace_back(static_cast<int>(k), static_cast<int>(index), weight);
    }
  }
  fine_from_active_.resize(static_cast<Eigen::Index>(rows.back().size()), static_cast<Eigen::Index>(size_));
  fine_from_active_.setFromTriplets(triplets.begin(), triplets.end());
  BuildLeaves(rows);
}

Rows HierarchicalSpline::RowsOfLevel(std::size_t l, const std::vector<char>& domain, const std::vector<Rows>& coarser) {
  const SplineLevel& level = levels_[l];
  const std::size_t width = level.theta.count();
  const auto z_weights =
      l > 0 ? RefinementWeights(levels_[l - 1].z, level.z) : std::vector<std::vector<RefinementEntry>>();
  Rows rows(width * level.z.count());
  for (std::size_t j = 0; j < level.z.count(); ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      SparseRow& row = rows[j * width + i];
      if (AllUnder(level, domain, i, j)) {
        // Kraft's selection: active unless finer functions replace it. Truncation: coarser functions have no weight
        // here.
        const bool replaced = l < flags_.size() && AllUnder(level, flags_[l], i, j);
        if (!replaced) row.emplace_back(static_cast<std::uint32_t>(size_++), 1.0);
        continue;
      }
      for (const RefinementEntry& up : z_weights[j]) {
        for (const RefinementEntry& around : PeriodicWeights(i, width / 2)) {
          AddScaled(row, coarser[l - 1][up.coarse * (width / 2) + around.coarse], up.weight * around.weight);
        }
      }
      Compress(row);
    }
  }
  return rows;
}

void HierarchicalSpline::BuildLeaves(const std::vector<Rows>& rows) {
  const std::size_t fine_width = finest().theta_cells();
  leaf_of_fine_cell_.assign(fine_width * finest().z_cells(), 0);
  std::vector<std::size_t> column(size_, 0);
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const SplineLevel& level = levels_[l];
    const std::size_t width = level.theta_cells();
    const std::size_t share = std::size_t{1} << (levels_.size() - 1 - l);  // fine cells along a side
    for (std::size_t j = 0; j < level.z_cells(); ++j) {
      for (std::size_t i = 0; i < width; ++i) {
        const bool lives = l == 0 || flags_[l - 1][(j / 2) * (width / 2) + i / 2] != 0;
        const bool split = l < flags_.size() && flags_[l][j * width + i] != 0;
        if (!lives || split) continue;
        SplineLeaf leaf{
            static_cast<std::uint8_t>(l), static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), {}, {}};
        // Local functions: theta i-1 … i+2, z j … j+3.
        std::array<const SparseRow*, 16> local{};
        for (std::size_t b = 0; b < 4; ++b) {
          for (std::size_t a = 0; a < 4; ++a) {
            local[4 * b + a] = &rows[l][(j + b) * width + (i + width - 1 + a) % width];
            for (const auto& entry : *local[4 * b + a]) leaf.active.push_back(entry.first);
          }
        }
        std::sort(leaf.active.begin(), leaf.active.end());
        leaf.active.erase(std::unique(leaf.active.begin(), leaf.active.end()), leaf.active.end());
        for (std::size_t k = 0; k < leaf.active.size(); ++k) column[leaf.active[k]] = k;
        leaf.extraction.setZero(static_cast<Eigen::Index>(leaf.active.size()), 16);
        for (std::size_t k = 0; k < 16; ++k) {
          for (const auto& [index, weight] : *local[k]) {
            leaf.extraction(static_cast<Eigen::Index>(column[index]), static_cast<Eigen::Index>(k)) = weight;
          }
        }
        for (std::size_t y = j * share; y < (j + 1) * share; ++y) {
          for (std::size_t x = i * share; x < (i + 1) * share; ++x) {
            leaf_of_fine_cell_[y * fine_width + x] = static_cast<std::uint32_t>(leaves_.size());
          }
        }
        leaves_.push_back(std::move(leaf));
      }
    }
  }
}

std::size_t HierarchicalSpline::LeafAt(double theta, double z) const {
  return leaf_of_fine_cell_[finest().z.Interval(z) * finest().theta_cells() + finest().theta.Interval(theta)];
}

std::vector<CoefficientWeight> HierarchicalSpline::ActiveRow(double theta, double z) const {
  const SplineLeaf& leaf = leaves_[LeafAt(theta, z)];
  const SplineLevel& level = levels_[leaf.level];
  const CubicBasis around = level.theta.InInterval(leaf.theta_cell, theta);
  const CubicBasis up = level.z.InInterval(leaf.z_cell, z);
  Eigen::Matrix<double, 16, 1> local;
  for (std::size_t b = 0; b < 4; ++b) {
    for (std::size_t a = 0; a < 4; ++a) local[static_cast<Eigen::Index>(4 * b + a)] = up.value[b] * around.value[a];
  }
  const Eigen::VectorXd weights = leaf.extraction * local;
  std::vector<CoefficientWeight> row;
  for (std::size_t k = 0; k < leaf.active.size(); ++k) {
    row.push_back({leaf.active[k], weights[static_cast<Eigen::Index>(k)]});
  }
  return row;
}

SplineSurface HierarchicalSpline::Surface(const Eigen::VectorXd& active) const {
  return {finest().theta, finest().z, fine_from_active_ * active};
}

RefinementFlags HierarchicalSpline::WithMarks(std::size_t level, const std::vector<char>& marks) const {
  RefinementFlags flags = flags_;
  const std::size_t fine_width = finest().theta_cells();
  const std::size_t share = std::size_t{1} << (levels_.size() - 1 - level);  // fine cells along a cell of `level`
  const SplineLevel& own = levels_[level];
  const std::size_t width = own.theta_cells();
  for (std::size_t k = 0; k < marks.size(); ++k) {
    if (marks[k] == 0) continue;
    // The 4 × 4 functions of the next level over the mark reach 3 of its cells to either side: 2 cells of this level.
    const auto half_i = static_cast<std::ptrdiff_t>((k % fine_width) * 2 / share);
    const auto half_j = static_cast<std::ptrdiff_t>((k / fine_width) * 2 / share);
    const auto floor_half = [](std::ptrdiff_t x) { return x >= 0 ? x / 2 : -((1 - x) / 2); };
    for (std::ptrdiff_t j = floor_half(half_j - 3); j <= floor_half(half_j + 3); ++j) {
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(own.z_cells())) continue;
      for (std::ptrdiff_t i = floor_half(half_i - 3); i <= floor_half(half_i + 3); ++i) {
        const auto n = static_cast<std::ptrdiff_t>(width);
        flags[level][static_cast<std::size_t>(j) * width + static_cast<std::size_t>((i % n + n) % n)] = 1;
      }
    }
  }
  return flags;
}

}  // namespace annulus
