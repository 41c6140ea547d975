#include "fitting/hierarchical_spline.h"

#include <algorithm>
#include <array>

#include "base/ensure.h"

namespace annulus {
namespace {

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

/// Weights of periodic subdivision: fine spline 2k (centred on coarse knot k) and 2k + 1 (between; the last weight is
/// 0).
std::array<RefinementEntry, 3> PeriodicWeights(std::size_t fine, std::size_t coarse_count) {
  const std::size_t k = fine / 2;
  const std::size_t next = (k + 1) % coarse_count;
  if (fine % 2 == 0) return {{{(k + coarse_count - 1) % coarse_count, 0.125}, {k, 0.75}, {next, 0.125}}};
  return {{{k, 0.5}, {next, 0.5}, {next, 0.0}}};
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
  std::vector<char> domain(levels_[0].theta_cells() * levels_[0].z_cells(), 1);  // of a level, nested by force
  for (std::size_t l = 0; l <= flags_.size(); ++l) {
    if (l < flags_.size()) {
      ENSURE(flags_[l].size() == domain.size(), "one flag per cell");
      for (std::size_t k = 0; k < domain.size(); ++k) flags_[l][k] = flags_[l][k] != 0 && domain[k] != 0 ? 1 : 0;
    }
    DecideFates(l, domain);
    if (l == flags_.size()) break;
    domain = Children(levels_[l], flags_[l]);
    SplineLevel finer{PeriodicCubicBasis(2 * levels_[l].theta_cells()),
                      ClampedCubicBasis(Halved(levels_[l].z.breakpoints()))};
    levels_.push_back(std::move(finer));
  }
  BuildLeaves();
}

void HierarchicalSpline::DecideFates(std::size_t l, const std::vector<char>& domain) {
  const SplineLevel& level = levels_[l];
  const std::size_t width = level.theta.count();
  Fates fates(width * level.z.count(), kCoarser);
  for (std::size_t j = 0; j < level.z.count(); ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      if (!AllUnder(level, domain, i, j)) continue;
      // Kraft's selection: active unless finer functions replace it.
      const bool replaced = l < flags_.size() && AllUnder(level, flags_[l], i, j);
      fates[j * width + i] = replaced ? kReplaced : static_cast<std::int32_t>(size_++);
    }
  }
  fates_.push_back(std::move(fates));
}

/// Collects the leaves of all levels. Remembers how the functions of a level are made of active ones.
class HierarchicalSpline::LeafBuilder {
 public:
  explicit LeafBuilder(const HierarchicalSpline& spline)
      : spline_(spline), rows_(spline.levels_.size()), sums_(spline.levels_.size()) {
    for (std::size_t l = 0; l < rows_.size(); ++l) {
      rows_[l].resize(spline.fates_[l].size());
      z_weights_.push_back(l == 0 ? std::vector<std::vector<RefinementEntry>>()
                                  : RefinementWeights(spline.levels_[l - 1].z, spline.levels_[l].z));
    }
    column_.assign(spline.size_, kNoColumn);
  }

  /// Appends the leaf over a cell to the pools of the spline that is being built.
  void Append(std::size_t l, std::size_t theta_cell, std::size_t z_cell, HierarchicalSpline& spline) {
    const std::size_t width = spline.levels_[l].theta_cells();
    SplineLeaf leaf;
    leaf.theta_cell = static_cast<std::uint32_t>(theta_cell);
    leaf.z_cell = static_cast<std::uint32_t>(z_cell);
    leaf.level = static_cast<std::uint8_t>(l);
    leaf.first = static_cast<std::uint32_t>(spline.active_.size());
    leaf.extraction_first = static_cast<std::uint32_t>(spline.extraction_.size());
    leaf.plain = true;
    std::array<std::size_t, 16> local{};  // theta i-1 … i+2, z j … j+3
    for (std::size_t k = 0; k < 16; ++k) {
      local[k] = (z_cell + k / 4) * width + (theta_cell + width - 1 + k % 4) % width;
      leaf.plain = leaf.plain && spline.fates_[l][local[k]] >= 0;
    }
    if (leaf.plain) {
      for (const std::size_t f : local) spline.active_.push_back(static_cast<std::uint32_t>(spline.fates_[l][f]));
    } else {
      AppendMixed(l, local, spline);
    }
    leaf.count = static_cast<std::uint16_t>(spline.active_.size() - leaf.first);
    leaf.extraction_count = static_cast<std::uint16_t>(spline.extraction_.size() - leaf.extraction_first);
    spline.leaves_.push_back(leaf);
  }

 private:
  using Entry = std::pair<std::uint32_t, double>;  ///< Active index and weight.
  struct Row {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool known = false;
  };
  static constexpr std::uint32_t kNoColumn = ~std::uint32_t{0};

  void AppendMixed(std::size_t l, const std::array<std::size_t, 16>& local, HierarchicalSpline& spline) {
    const std::size_t first = spline.active_.size();
    std::array<Row, 16> rows;
    for (std::size_t k = 0; k < 16; ++k) {
      rows[k] = RowOf(l, local[k]);
      for (std::uint32_t e = 0; e < rows[k].count; ++e) {
        const std::uint32_t index = entries_[rows[k].first + e].first;
        if (column_[index] != kNoColumn) continue;
        column_[index] = 0;
        spline.active_.push_back(index);
      }
    }
    const auto begin = spline.active_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, spline.active_.end());
    const std::size_t count = spline.active_.size() - first;
    for (std::size_t k = 0; k < count; ++k) column_[spline.active_[first + k]] = static_cast<std::uint32_t>(k);
    for (std::size_t k = 0; k < 16; ++k) {
      for (std::uint32_t e = 0; e < rows[k].count; ++e) {
        const auto& [index, weight] = entries_[rows[k].first + e];
        spline.extraction_.push_back(
            {weight, static_cast<std::uint16_t>(k), static_cast<std::uint16_t>(column_[index])});
      }
    }
    for (std::size_t k = 0; k < count; ++k) column_[spline.active_[first + k]] = kNoColumn;
  }

  /// Weights of the active coefficients on function f of level l.
  Row RowOf(std::size_t l, std::size_t f) {
    Row& known = rows_[l][f];
    if (known.known) return known;
    std::vector<Entry>& sum = sums_[l];
    sum.clear();
    const std::int32_t fate = spline_.fates_[l][f];
    if (fate >= 0) {
      sum.emplace_back(static_cast<std::uint32_t>(fate), 1.0);
    } else if (fate == kCoarser) {
      const std::size_t width = spline_.levels_[l].theta_cells();
      for (const RefinementEntry& up : z_weights_[l][f / width]) {
        for (const RefinementEntry& around : PeriodicWeights(f % width, width / 2)) {
          const Row row = RowOf(l - 1, up.coarse * (width / 2) + around.coarse);
          for (std::uint32_t e = 0; e < row.count; ++e) {
            const auto& [index, weight] = entries_[row.first + e];
            const double share = up.weight * around.weight * weight;
            if (share == 0.0) continue;
            const auto same =
                std::find_if(sum.begin(), sum.end(), [&, i = index](const Entry& s) { return s.first == i; });
            if (same == sum.end()) {
              sum.emplace_back(index, share);
            } else {
              same->second += share;
            }
          }
        }
      }
    }
    known = {static_cast<std::uint32_t>(entries_.size()), static_cast<std::uint32_t>(sum.size()), true};
    entries_.insert(entries_.end(), sum.begin(), sum.end());
    return known;
  }

  const HierarchicalSpline& spline_;
  std::vector<std::vector<Row>> rows_;
  std::vector<Entry> entries_;
  std::vector<std::vector<Entry>> sums_;  ///< Scratch, by level.
  std::vector<std::vector<std::vector<RefinementEntry>>> z_weights_;
  std::vector<std::uint32_t> column_;  ///< Of an active coefficient in the leaf at hand.
};

void HierarchicalSpline::BuildLeaves() {
  const std::size_t fine_width = finest().theta_cells();
  leaf_of_fine_cell_.assign(fine_width * finest().z_cells(), 0);
  LeafBuilder builder(*this);
  // Room that is not used is never touched, and growing step by step would touch it many times.
  const std::size_t most = std::min<std::size_t>(leaf_of_fine_cell_.size(), 20'000);
  leaves_.reserve(most);
  active_.reserve(20 * most);
  extraction_.reserve(60 * most);
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const std::size_t width = levels_[l].theta_cells();
    const std::size_t share = std::size_t{1} << (levels_.size() - 1 - l);  // fine cells along a side
    for (std::size_t j = 0; j < levels_[l].z_cells(); ++j) {
      for (std::size_t i = 0; i < width; ++i) {
        const bool lives = l == 0 || flags_[l - 1][(j / 2) * (width / 2) + i / 2] != 0;
        const bool split = l < flags_.size() && flags_[l][j * width + i] != 0;
        if (!lives || split) continue;
        for (std::size_t y = j * share; y < (j + 1) * share; ++y) {
          std::fill_n(leaf_of_fine_cell_.begin() + static_cast<std::ptrdiff_t>(y * fine_width + i * share), share,
                      static_cast<std::uint32_t>(leaves_.size()));
        }
        builder.Append(l, i, j, *this);
      }
    }
  }
}

std::size_t HierarchicalSpline::LeafAt(double theta, double z) const {
  return leaf_of_fine_cell_[finest().z.Interval(z) * finest().theta_cells() + finest().theta.Interval(theta)];
}

Eigen::Matrix<double, 16, 1> HierarchicalSpline::Local(const SplineLeaf& leaf, const Eigen::VectorXd& active) const {
  Eigen::Matrix<double, 16, 1> local = Eigen::Matrix<double, 16, 1>::Zero();
  const std::span<const std::uint32_t> indices = Active(leaf);
  if (leaf.plain) {
    for (std::size_t k = 0; k < 16; ++k) {
      local[static_cast<Eigen::Index>(k)] = active[static_cast<Eigen::Index>(indices[k])];
    }
    return local;
  }
  for (const ExtractionEntry& e : Extraction(leaf)) {
    local[e.local] += e.weight * active[static_cast<Eigen::Index>(indices[e.active])];
  }
  return local;
}

std::vector<CoefficientWeight> HierarchicalSpline::ActiveRow(double theta, double z) const {
  const SplineLeaf& leaf = leaves_[LeafAt(theta, z)];
  const SplineLevel& level = levels_[leaf.level];
  const CubicBasis around = level.theta.InInterval(leaf.theta_cell, theta);
  const CubicBasis up = level.z.InInterval(leaf.z_cell, z);
  Eigen::Matrix<double, 16, 1> local;
  for (std::size_t k = 0; k < 16; ++k) local[static_cast<Eigen::Index>(k)] = up.value[k / 4] * around.value[k % 4];
  std::vector<CoefficientWeight> row;
  for (const std::uint32_t index : Active(leaf)) row.push_back({index, 0.0});
  if (leaf.plain) {
    for (std::size_t k = 0; k < 16; ++k) row[k].weight = local[static_cast<Eigen::Index>(k)];
  }
  for (const ExtractionEntry& e : Extraction(leaf)) row[e.active].weight += e.weight * local[e.local];
  return row;
}

SplineSurface HierarchicalSpline::Surface(const Eigen::VectorXd& active) const {
  Eigen::VectorXd coarse;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const std::size_t width = levels_[l].theta_cells();
    const auto z_weights =
        l == 0 ? std::vector<std::vector<RefinementEntry>>() : RefinementWeights(levels_[l - 1].z, levels_[l].z);
    Eigen::VectorXd level = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fates_[l].size()));
    for (std::size_t f = 0; f < fates_[l].size(); ++f) {
      double& value = level[static_cast<Eigen::Index>(f)];
      if (fates_[l][f] >= 0) value = active[fates_[l][f]];
      if (fates_[l][f] != kCoarser) continue;
      for (const RefinementEntry& up : z_weights[f / width]) {
        for (const RefinementEntry& around : PeriodicWeights(f % width, width / 2)) {
          value +=
              up.weight * around.weight * coarse[static_cast<Eigen::Index>(up.coarse * (width / 2) + around.coarse)];
        }
      }
    }
    coarse = std::move(level);
  }
  return {finest().theta, finest().z, std::move(coarse)};
}

Eigen::VectorXd HierarchicalSpline::ActiveGradient(const Eigen::VectorXd& tensor_gradient) const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size_));
  Eigen::VectorXd level = tensor_gradient;
  for (std::size_t l = levels_.size(); l-- > 0;) {
    const std::size_t width = levels_[l].theta_cells();
    const auto z_weights =
        l == 0 ? std::vector<std::vector<RefinementEntry>>() : RefinementWeights(levels_[l - 1].z, levels_[l].z);
    Eigen::VectorXd coarse = Eigen::VectorXd::Zero(l == 0 ? 0 : static_cast<Eigen::Index>(fates_[l - 1].size()));
    for (std::size_t f = 0; f < fates_[l].size(); ++f) {
      const double value = level[static_cast<Eigen::Index>(f)];
      if (fates_[l][f] >= 0) gradient[fates_[l][f]] += value;
      if (fates_[l][f] != kCoarser || value == 0.0) continue;
      for (const RefinementEntry& up : z_weights[f / width]) {
        for (const RefinementEntry& around : PeriodicWeights(f % width, width / 2)) {
          coarse[static_cast<Eigen::Index>(up.coarse * (width / 2) + around.coarse)] +=
              up.weight * around.weight * value;
        }
      }
    }
    level = std::move(coarse);
  }
  return gradient;
}

}  // namespace annulus
