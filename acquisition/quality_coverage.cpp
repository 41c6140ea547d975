#include "acquisition/quality_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

/// How directions of a row are known, before gaps are told from the void.
struct Counts {
  std::uint32_t levels = 0;
  std::uint32_t seen = 0;
  std::uint32_t beyond = 0;  ///< Passed this side and met something beyond the axis.
};

/// The widest gap that a scan without any return beyond the axis is believed to have (imported tables leave these out):
/// wider ones are the void between legs.
constexpr double kWidestUnproven = 40.0 * kPi / 180.0;

/// Gaps of one row: a direction without a return is one if its line certainly meets the body on this side. `widest`:
/// columns, for those of which only the neighbours speak.
void FindGaps(CoverageMap& map, const std::vector<Counts>& counts, std::size_t row, std::size_t widest) {
  const std::size_t n = map.columns;
  const Counts* const at = counts.data() + row * n;
  const auto is_void = [&](std::size_t c) { return at[c].seen == 0 && at[c].beyond == 0; };
  for (std::size_t c = 0; c < n; ++c) {
    if (at[c].levels == 0 || !is_void(c)) continue;
    const Counts& opposite = at[(c + n / 2) % n];
    bool gap = opposite.beyond > 0;  // what the opposite sensor saw beyond the axis lies on this side
    if (!gap) {
      std::size_t left = 1;
      std::size_t right = 1;
      while (left < n && is_void((c + left) % n)) ++left;
      while (right < n && is_void((c + n - right) % n)) ++right;
      const bool between = left < n && at[(c + left) % n].seen > 0 && at[(c + n - right) % n].seen > 0;
      gap = between && left + right - 1 <= (opposite.seen > 0 ? widest : 2);
    }
    if (gap) map.cells[row * n + c] = CoverageCell::kGap;
  }
}

/// Rows that no level fell on, between rows of the body.
void BridgeEmptyRows(CoverageMap& map, const std::vector<Counts>& counts) {
  const auto empty = [&](std::size_t row) { return counts[row * map.columns].levels == 0; };
  for (std::size_t row = 0; row < map.rows; ++row) {
    if (!empty(row)) continue;
    std::size_t below = row;
    std::size_t above = row;
    while (below > 0 && empty(below)) --below;
    while (above + 1 < map.rows && empty(above)) ++above;
    for (std::size_t c = 0; c < map.columns; ++c) {
      const bool body = counts[below * map.columns + c].seen > 0 && counts[above * map.columns + c].seen > 0;
      if (body) map.cells[row * map.columns + c] = CoverageCell::kGap;
    }
  }
}

/// Cells of one kind that hang together, over the seam too.
class Regions {
 public:
  Regions(const CoverageMap& map, CoverageCell kind) : map_(map), kind_(kind), done_(map.cells.size(), 0) {}

  /// The cells of the region that holds `start`; empty if it is known already or of another kind.
  std::vector<std::size_t> Take(std::size_t start) {
    std::vector<std::size_t> found;
    const auto push = [&](std::size_t cell) {
      if (done_[cell] != 0 || map_.cells[cell] != kind_) return;
      done_[cell] = 1;
      found.push_back(cell);
    };
    push(start);
    const std::size_t n = map_.columns;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const std::size_t row = found[k] / n;
      const std::size_t column = found[k] % n;
      for (std::size_t r = row > 0 ? row - 1 : 0; r <= std::min(row + 1, map_.rows - 1); ++r) {
        for (const std::size_t c : {(column + n - 1) % n, column, (column + 1) % n}) push(r * n + c);
      }
    }
    return found;
  }

 private:
  const CoverageMap& map_;
  CoverageCell kind_;
  std::vector<std::uint8_t> done_;
};

/// The shortest arc that holds all marked columns.
std::pair<std::size_t, std::size_t> ArcOf(const std::vector<std::uint8_t>& marked) {
  const std::size_t n = marked.size();
  std::size_t best_gap = 0;
  std::size_t from = 0;
  for (std::size_t c = 0; c < n; ++c) {
    if (marked[c] == 0 || marked[(c + n - 1) % n] != 0) continue;
    std::size_t gap = 1;
    while (gap < n && marked[(c + n - gap) % n] == 0) ++gap;
    if (gap > best_gap) {
      best_gap = gap;
      from = c;
    }
  }
  return {from, best_gap == 0 ? n : n - (best_gap - 1)};  // first column, and how many
}

/// Whether a block of the least size, in `rows` rows, lies in the region.
bool HoldsBlock(const CoverageMap& map, const std::vector<std::size_t>& cells, std::size_t rows, std::size_t columns) {
  const CoverageCell kind = map.cells[cells.front()];
  const std::size_t n = map.columns;
  return std::any_of(cells.begin(), cells.end(), [&](std::size_t cell) {
    const std::size_t row = cell / n;
    if (row + rows > map.rows) return false;
    for (std::size_t r = row; r < row + rows; ++r) {
      for (std::size_t c = 0; c < columns; ++c) {
        if (map.At(r, (cell % n + c) % n) != kind) return false;
      }
    }
    return true;
  });
}

/// A difference over readings, scaled to a reading of full quality; NaN where one of them is missing.
class Differences {
 public:
  explicit Differences(const QualityGrid& grid) : grid_(grid) {}
  void Add(std::size_t level, std::size_t column, double factor) {
    const std::uint8_t quality = grid_.Quality(level, column);
    const double radius = grid_.Radius(level, column);
    if (!(radius > 0.0) || quality == 0) usable_ = false;
    if (!usable_) return;
    sum_ += factor * radius;
    variance_ += factor * factor * 255.0 / static_cast<double>(quality);
  }
  void Finish(std::vector<float>& into) {
    if (usable_) into.push_back(static_cast<float>(std::abs(sum_) / std::sqrt(variance_)));
    usable_ = true;
    sum_ = variance_ = 0.0;
  }

 private:
  const QualityGrid& grid_;
  bool usable_ = true;
  double sum_ = 0.0, variance_ = 0.0;
};

constexpr std::array<double, 5> kFourth{1.0, -4.0, 6.0, -4.0, 1.0};
constexpr std::array<double, 3> kSecond{1.0, -2.0, 1.0};

/// Whether levels [first, first + count) are of one sweep.
bool OneSweep(const QualityGrid& grid, std::size_t first, std::size_t count) {
  return first + count <= grid.levels().size() && grid.levels()[first].sweep == grid.levels()[first + count - 1].sweep;
}

double SigmaOf(std::vector<float>& differences) {
  constexpr std::size_t kFewest = 50;
  constexpr double kMedianOfHalfNormal = 0.6744897501960817;
  if (differences.size() < kFewest) return std::numeric_limits<double>::infinity();
  return MedianOf(differences) / kMedianOfHalfNormal;
}

}  // namespace

CoverageMap MapCoverage(const QualityGrid& grid, double row_mm) {
  CoverageMap map;
  map.columns = grid.columns();
  map.row_mm = row_mm;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    if (std::none_of(grid.Radii(k).begin(), grid.Radii(k).end(), [](float r) { return r > 0.0F; })) continue;
    low = std::min(low, grid.levels()[k].z);
    high = std::max(high, grid.levels()[k].z);
  }
  constexpr std::size_t kMostRows = 4000;
  if (!(high >= low)) return map;
  map.z_min = low - 0.5 * row_mm;
  map.rows = std::min(kMostRows, static_cast<std::size_t>((high - map.z_min) / row_mm) + 1);
  std::vector<Counts> counts(map.rows * map.columns);
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    const double place = (grid.levels()[k].z - map.z_min) / row_mm;
    if (!(place >= 0.0) || place >= static_cast<double>(map.rows)) continue;
    Counts* const at = counts.data() + static_cast<std::size_t>(place) * map.columns;
    for (std::size_t c = 0; c < map.columns; ++c) {
      const float radius = grid.Radius(k, c);
      ++at[c].levels;
      if (radius > 0.0F) ++at[c].seen;
      if (radius <= 0.0F) ++at[c].beyond;
    }
  }
  map.cells.assign(map.rows * map.columns, CoverageCell::kOutside);
  for (std::size_t k = 0; k < map.cells.size(); ++k) {
    if (counts[k].seen > 0) map.cells[k] = CoverageCell::kSeen;
  }
  const bool sees_beyond = std::any_of(counts.begin(), counts.end(), [](const Counts& c) { return c.beyond > 0; });
  const std::size_t widest = sees_beyond ? map.columns : static_cast<std::size_t>(kWidestUnproven / grid.step());
  for (std::size_t row = 0; row < map.rows; ++row) FindGaps(map, counts, row, widest);
  BridgeEmptyRows(map, counts);
  return map;
}

double CoverageOf(const CoverageMap& map) {
  std::size_t seen = 0;
  std::size_t gaps = 0;
  for (const CoverageCell cell : map.cells) {
    if (cell == CoverageCell::kSeen || cell == CoverageCell::kDoubtful) ++seen;
    if (cell == CoverageCell::kGap) ++gaps;
  }
  return seen == 0 ? 0.0 : static_cast<double>(seen) / static_cast<double>(seen + gaps);
}

std::vector<QualityRegion> RegionsOf(const CoverageMap& map, CoverageCell kind, const LeastRegion& least) {
  std::vector<QualityRegion> regions;
  Regions search(map, kind);
  const auto rows = static_cast<std::size_t>(std::max(1.0, std::ceil(least.height_mm / map.row_mm - 1e-9)));
  for (std::size_t start = 0; start < map.cells.size(); ++start) {
    const std::vector<std::size_t> cells = search.Take(start);
    if (cells.empty() || !HoldsBlock(map, cells, rows, least.columns)) continue;
    std::vector<std::uint8_t> marked(map.columns, 0);
    std::size_t low = map.rows;
    std::size_t high = 0;
    for (const std::size_t cell : cells) {
      marked[cell % map.columns] = 1;
      low = std::min(low, cell / map.columns);
      high = std::max(high, cell / map.columns);
    }
    const auto [from, width] = ArcOf(marked);
    const double step = kTwoPi / static_cast<double>(map.columns);
    QualityRegion region;
    region.theta_from = WrapAngle((static_cast<double>(from) - 0.5) * step);
    region.theta_to = region.theta_from + static_cast<double>(width) * step;
    region.z_min = map.z_min + static_cast<double>(low) * map.row_mm;
    region.z_max = map.z_min + static_cast<double>(high + 1) * map.row_mm;
    region.cells = cells.size();
    regions.push_back(region);
  }
  std::stable_sort(regions.begin(), regions.end(),
                   [](const QualityRegion& a, const QualityRegion& b) { return a.cells > b.cells; });
  return regions;
}

double EstimateNoise(const QualityGrid& grid) {
  std::vector<float> around;
  std::vector<float> along;
  std::vector<float> both;
  Differences difference(grid);
  const std::size_t n = grid.columns();
  for (std::size_t level = 0; level < grid.levels().size(); ++level) {
    const bool five = OneSweep(grid, level, kFourth.size());
    const bool three = OneSweep(grid, level, kSecond.size());
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t k = 0; k < kFourth.size(); ++k) difference.Add(level, (c + k) % n, kFourth[k]);
      difference.Finish(around);
      if (five) {
        for (std::size_t k = 0; k < kFourth.size(); ++k) difference.Add(level + k, c, kFourth[k]);
        difference.Finish(along);
      }
      if (!three) continue;
      for (std::size_t k = 0; k < kSecond.size(); ++k) {
        for (std::size_t j = 0; j < kSecond.size(); ++j) {
          difference.Add(level + k, (c + j) % n, kSecond[k] * kSecond[j]);
        }
      }
      difference.Finish(both);
    }
  }
  const double sigma = std::min({SigmaOf(around), SigmaOf(along), SigmaOf(both)});
  return std::isfinite(sigma) ? sigma : 0.0;
}

double EstimateSpikes(const QualityGrid& grid, double noise_sigma_mm) {
  constexpr double kAgree = 4.0;  // mm, of neighbours on either side
  const double far = std::max(8.0, 8.0 * noise_sigma_mm);
  const double agree = std::max(kAgree, 4.0 * noise_sigma_mm);
  std::size_t judged = 0;
  std::size_t spikes = 0;
  const std::size_t n = grid.columns();
  for (std::size_t level = 0; level < grid.levels().size(); ++level) {
    for (std::size_t c = 0; c < n; ++c) {
      const double radius = grid.Radius(level, c);
      const double left = grid.Radius(level, (c + n - 1) % n);
      const double right = grid.Radius(level, (c + 1) % n);
      if (std::isnan(radius) || !(std::abs(left - right) < agree)) continue;
      ++judged;
      if (std::abs(radius - left) > far && std::abs(radius - right) > far) ++spikes;
    }
  }
  return judged == 0 ? 0.0 : static_cast<double>(spikes) / static_cast<double>(judged);
}

double MedianQuality(const QualityGrid& grid) {
  std::array<std::size_t, 256> histogram{};
  std::size_t count = 0;
  for (std::size_t level = 0; level < grid.levels().size(); ++level) {
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      if (!grid.Seen(level, c)) continue;
      ++histogram[grid.Quality(level, c)];
      ++count;
    }
  }
  std::size_t below = 0;
  for (std::size_t value = 0; value < histogram.size(); ++value) {
    below += histogram[value];
    if (2 * below > count) return static_cast<double>(value) / 255.0;
  }
  return 0.0;
}

}  // namespace annulus
