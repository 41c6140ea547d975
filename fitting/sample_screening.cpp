#include "fitting/sample_screening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr double kMadToSigma = 1.4826;  // sd of a normal distribution over its median absolute deviation

/// A cell of a SampleGrid.
struct GridCell {
  std::size_t row = 0;
  std::size_t column = 0;
};

/// The radii of the good samples by cell, NaN where there is none, with a margin of two cells (NaN above and below,
/// the columns of the other side to the left and right), so that a neighbour is a fixed step away in memory.
class RadiusField {
 public:
  static constexpr std::size_t kMargin = 2;

  RadiusField(std::span<const SurfaceSample> samples, const SampleGrid& grid, std::span<const SampleVerdict> verdicts)
      : columns_(grid.columns()), stride_(columns_ + 2 * kMargin) {
    radii_.assign((grid.rows() + 2 * kMargin) * stride_, kNoRadius);
    for (std::size_t row = 0; row < grid.rows(); ++row) {
      double* radii = radii_.data() + (row + kMargin) * stride_;
      for (std::size_t column = 0; column < columns_; ++column) {
        const std::size_t k = grid.At(row, column);
        if (k != SampleGrid::kNone && verdicts[k] == SampleVerdict::kGood) radii[column + kMargin] = samples[k].radius;
      }
      for (std::size_t k = 0; k < kMargin; ++k) {
        radii[k] = radii[kMargin + (columns_ * kMargin + k - kMargin) % columns_];
        radii[columns_ + kMargin + k] = radii[kMargin + k % columns_];
      }
    }
  }

  [[nodiscard]] const double* Row(std::size_t row) const { return radii_.data() + (row + kMargin) * stride_ + kMargin; }
  [[nodiscard]] const double* At(GridCell cell) const { return Row(cell.row) + cell.column; }
  [[nodiscard]] std::ptrdiff_t stride() const { return static_cast<std::ptrdiff_t>(stride_); }

  /// Changes a cell, and its copies in the margins.
  void Set(GridCell cell, double radius) {
    double* radii = radii_.data() + (cell.row + kMargin) * stride_;
    for (std::size_t k = (cell.column + kMargin) % columns_; k < stride_; k += columns_) radii[k] = radius;
  }
  void Remove(GridCell cell) { Set(cell, kNoRadius); }

 private:
  static constexpr double kNoRadius = std::numeric_limits<double>::quiet_NaN();

  std::size_t columns_;
  std::size_t stride_;
  std::vector<double> radii_;
};

/// Steps from a cell of a RadiusField to its (2·half + 1)² − 1 neighbours, nearest first.
std::vector<std::ptrdiff_t> StepsAround(const RadiusField& field, std::ptrdiff_t half) {
  std::vector<std::array<std::ptrdiff_t, 2>> offsets;
  for (std::ptrdiff_t dr = -half; dr <= half; ++dr) {
    for (std::ptrdiff_t dc = -half; dc <= half; ++dc) {
      if (dr != 0 || dc != 0) offsets.push_back({dr, dc});
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const auto& a, const auto& b) { return a[0] * a[0] + a[1] * a[1] < b[0] * b[0] + b[1] * b[1]; });
  std::vector<std::ptrdiff_t> steps;
  for (const auto& [dr, dc] : offsets) steps.push_back(dr * field.stride() + dc);
  return steps;
}

/// What a return needs around it to be believed.
struct Company {
  int neighbours = 0;     ///< At least so many.
  int vouchers = 0;       ///< At least so many of them that it is not far above, and as many that it is not far below.
  double limit_mm = 0.0;  ///< What "far" is.
};

/// Whether a cell has the company it needs among the cells at `steps`. Looks no further than it must.
bool HasCompany(const double* cell, std::span<const std::ptrdiff_t> steps, const Company& needed) {
  int neighbours = 0;
  int not_above = 0;
  int not_below = 0;
  for (const std::ptrdiff_t step : steps) {
    const double excess = *cell - cell[step];
    if (std::isnan(excess)) continue;
    ++neighbours;
    not_above += excess > needed.limit_mm ? 0 : 1;
    not_below += -excess > needed.limit_mm ? 0 : 1;
    if (neighbours >= needed.neighbours && not_above >= needed.vouchers && not_below >= needed.vouchers) return true;
  }
  return false;
}

/// Finds outliers among the cells of `field`, and takes them out of it.
std::vector<GridCell> TakeOutliers(const ScreeningOptions& options, const SampleGrid& grid, RadiusField& field) {
  struct Candidate {
    GridCell cell;
    double radius = 0.0;
  };
  std::vector<Candidate> candidates;
  const std::vector<std::ptrdiff_t> wide = StepsAround(field, 2);
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    const double* radii = field.Row(row);
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const double* cell = radii + column;
      if (std::isnan(*cell) || HasCompany(cell, wide, {4, 2, options.outlier_candidate_mm})) continue;
      candidates.push_back({{row, column}, *cell});
    }
  }
  // A candidate is confirmed against its neighbours that are not candidates: an edge has company, an outlier has not.
  for (const Candidate& c : candidates) field.Remove(c.cell);
  const std::vector<std::ptrdiff_t> narrow = StepsAround(field, 1);
  std::vector<GridCell> outliers;
  std::vector<Candidate> cleared;
  for (const Candidate& c : candidates) {
    field.Set(c.cell, c.radius);
    const bool has_company = HasCompany(field.At(c.cell), narrow, {1, 1, options.outlier_confirm_mm});
    field.Remove(c.cell);
    if (has_company) {
      cleared.push_back(c);
    } else {
      outliers.push_back(c.cell);
    }
  }
  for (const Candidate& c : cleared) field.Set(c.cell, c.radius);
  return outliers;
}

/// The good returns of one row, in order.
struct GoodReturns {
  std::vector<std::size_t> columns;
  std::vector<double> radii;
};

GoodReturns GoodReturnsOf(const RadiusField& field, const SampleGrid& grid, std::size_t row) {
  GoodReturns good;
  const double* radii = field.Row(row);
  for (std::size_t column = 0; column < grid.columns(); ++column) {
    if (std::isnan(radii[column])) continue;
    good.columns.push_back(column);
    good.radii.push_back(radii[column]);
  }
  return good;
}

/// A run of columns of one row that stands before both its sides.
struct Run {
  std::size_t first = 0;  ///< Position in the list of good returns.
  std::size_t length = 0;
};

std::vector<Run> ForegroundRuns(const GoodReturns& good, const SampleGrid& grid, const ScreeningOptions& options) {
  const std::size_t n = good.columns.size();
  std::vector<Run> runs;
  if (n < 8) return runs;
  double before = good.radii[n - 1];
  for (std::size_t start = 0; start < n; ++start) {
    const double rise = good.radii[start] - before;
    before = good.radii[start];
    if (rise < options.foreground_step_mm) continue;
    for (std::size_t length = 1; length < n / 2; ++length) {
      const std::size_t last = (start + length - 1) % n;
      const double step = good.radii[(start + length) % n] - good.radii[last];
      const double width = WrapAngle(grid.column_theta(good.columns[last]) - grid.column_theta(good.columns[start]));
      if (width > options.foreground_width_rad || step > options.foreground_step_mm) break;
      if (step < -options.foreground_step_mm) {
        runs.push_back({start, length});
        break;
      }
    }
  }
  return runs;
}

/// Foreground objects that grow as rows are added from below.
class ObjectList {
 public:
  /// An object that ends more than `gap_mm` below a run is complete.
  explicit ObjectList(double gap_mm) : gap_mm_(gap_mm) {}

  /// Merges a run into the object it continues (same side), or starts a new one. Rows must ascend.
  void Add(double z, double theta, std::size_t samples) {
    while (first_open_ < objects_.size() && z - objects_[first_open_].z_max > gap_mm_) ++first_open_;
    for (std::size_t k = first_open_; k < objects_.size(); ++k) {
      ForegroundObject& object = objects_[k];
      if (z - object.z_max <= gap_mm_ && std::abs(AngleDifference(theta, object.theta)) < 0.35) {
        object.z_max = z;
        object.theta = theta;
        object.samples += samples;
        return;
      }
    }
    objects_.push_back({z, z, theta, samples});
  }

  [[nodiscard]] std::vector<ForegroundObject> Take() { return std::move(objects_); }

 private:
  double gap_mm_;
  std::vector<ForegroundObject> objects_;
  std::size_t first_open_ = 0;
};

/// What stands before the main surface.
struct Foreground {
  std::vector<ForegroundObject> objects;
  std::vector<GridCell> cells;
};

Foreground FindForeground(const SampleGrid& grid, const ScreeningOptions& options, const RadiusField& field) {
  const double pitch = grid.rows() > 1 ? (grid.row_z(grid.rows() - 1) - grid.row_z(0)) / double(grid.rows() - 1) : 1.0;
  ObjectList objects(std::max(20.0, 4.0 * pitch));
  Foreground foreground;
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    const GoodReturns good = GoodReturnsOf(field, grid, row);
    for (const Run& run : ForegroundRuns(good, grid, options)) {
      const auto column = [&](std::size_t k) { return good.columns[(run.first + k) % good.columns.size()]; };
      for (std::size_t k = 0; k < run.length; ++k) foreground.cells.push_back({row, column(k)});
      objects.Add(grid.row_z(row), grid.column_theta(column(run.length / 2)), run.length);
    }
  }
  foreground.objects = objects.Take();
  return foreground;
}

/// A level on which the run was not seen whole (a dropout or an outlier at its end) still belongs to the object:
/// returns that have foreground at a like radius on two sides are foreground too. One cell only: the shoulder is not
/// eaten away. `field` holds what is not foreground.
std::vector<GridCell> CloseForeground(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                                      const ScreeningOptions& options, const Foreground& foreground,
                                      const RadiusField& field) {
  std::vector<std::uint8_t> like(grid.rows() * grid.columns(), 0);
  std::vector<GridCell> closed;
  for (const GridCell& cell : foreground.cells) {
    const double radius = samples[grid.At(cell.row, cell.column)].radius;
    for (std::size_t row = cell.row - std::min<std::size_t>(cell.row, 1);
         row <= std::min(cell.row + 1, grid.rows() - 1); ++row) {
      for (std::ptrdiff_t dc = -1; dc <= 1; ++dc) {
        const GridCell other{row, grid.Column(cell.column, dc)};
        if (!(std::abs(radius - *field.At(other)) < 0.5 * options.foreground_step_mm)) continue;
        if (++like[other.row * grid.columns() + other.column] == 2) closed.push_back(other);
      }
    }
  }
  return closed;
}

double MedianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Screening ScreenSamples(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                        const ScreeningOptions& options) {
  Screening screening;
  screening.verdicts.assign(samples.size(), SampleVerdict::kOutlier);  // what the grid does not hold
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const std::size_t k = grid.At(row, column);
      if (k != SampleGrid::kNone) screening.verdicts[k] = SampleVerdict::kGood;
    }
  }
  RadiusField field(samples, grid, screening.verdicts);
  const auto mark = [&](const std::vector<GridCell>& cells, SampleVerdict verdict) {
    for (const GridCell& cell : cells) {
      screening.verdicts[grid.At(cell.row, cell.column)] = verdict;
      field.Remove(cell);
    }
  };
  // Two outliers near each other vouch for each other until one of them is gone: look again.
  constexpr int kMaxPasses = 4;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const std::vector<GridCell> outliers = TakeOutliers(options, grid, field);
    mark(outliers, SampleVerdict::kOutlier);
    if (outliers.empty()) break;
  }
  Foreground foreground = FindForeground(grid, options, field);
  if (!foreground.cells.empty()) {
    mark(foreground.cells, SampleVerdict::kForeground);
    mark(CloseForeground(samples, grid, options, foreground, field), SampleVerdict::kForeground);
    mark(TakeOutliers(options, grid, field), SampleVerdict::kOutlier);  // what is left of an object's edge stands alone
  }
  screening.foreground = std::move(foreground.objects);
  return screening;
}

namespace {

/// A sample and its four neighbours in the order of the ring.
struct Cross {
  const SurfaceSample& centre;
  const SurfaceSample& left;
  const SurfaceSample& right;
  const SurfaceSample& below;
  const SurfaceSample& above;
};

/// How far the centre is from the middle between `from` and `to` (left and right, or below and above), in noise
/// standard deviations of one return: where the three do not stand evenly in theta or height, the slope through the
/// four neighbours accounts for it. On an even grid this is the second difference over sqrt(6).
double Departure(const Cross& at, const SurfaceSample& from, const SurfaceSample& to) {
  const auto aside = [&](const SurfaceSample& s) { return AngleDifference(s.theta, at.centre.theta); };
  const double theta_off = -0.5 * (aside(from) + aside(to));
  const double z_off = at.centre.z - 0.5 * (from.z + to.z);
  // Slopes a, b: a·(θ_right − θ_left) + b·(z_right − z_left) = r_right − r_left, and the same upwards.
  const double theta_across = aside(at.right) - aside(at.left);
  const double z_across = at.right.z - at.left.z;
  const double theta_up = aside(at.above) - aside(at.below);
  const double z_up = at.above.z - at.below.z;
  const double determinant = theta_across * z_up - z_across * theta_up;
  double across = 0.0;  // weights of both differences of radii
  double up = 0.0;
  if (std::abs(determinant) > 1e-9) {  // else several sweeps at one height: nothing stands off
    across = (theta_off * z_up - z_off * theta_up) / determinant;
    up = (z_off * theta_across - theta_off * z_across) / determinant;
  }
  const double departure = at.centre.radius - 0.5 * (from.radius + to.radius) -
                           across * (at.right.radius - at.left.radius) - up * (at.above.radius - at.below.radius);
  return std::abs(departure) / std::sqrt(1.5 + 2.0 * (across * across + up * up));
}

}  // namespace

double EstimateNoise(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                     std::span<const SampleVerdict> verdicts) {
  constexpr std::size_t kEnough = 30;
  std::vector<double> sideways;
  std::vector<double> upwards;
  sideways.reserve(grid.rows() * grid.columns());
  upwards.reserve(grid.rows() * grid.columns());
  const auto good = [&](std::size_t row, std::size_t column) -> const SurfaceSample* {
    const std::size_t k = grid.At(row, column);
    return k != SampleGrid::kNone && verdicts[k] == SampleVerdict::kGood ? &samples[k] : nullptr;
  };
  for (std::size_t row = 1; row + 1 < grid.rows(); ++row) {
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const SurfaceSample* centre = good(row, column);
      const SurfaceSample* left = good(row, column == 0 ? grid.columns() - 1 : column - 1);
      const SurfaceSample* right = good(row, column + 1 == grid.columns() ? 0 : column + 1);
      const SurfaceSample* below = good(row - 1, column);
      const SurfaceSample* above = good(row + 1, column);
      if (centre == nullptr || left == nullptr || right == nullptr || below == nullptr || above == nullptr) continue;
      const Cross cross{*centre, *left, *right, *below, *above};
      sideways.push_back(Departure(cross, *left, *right));
      upwards.push_back(Departure(cross, *below, *above));
    }
  }
  if (sideways.size() < kEnough) return 0.0;
  return kMadToSigma * std::min(MedianOf(sideways), MedianOf(upwards));
}

}  // namespace annulus
