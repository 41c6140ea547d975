#include "fitting/sample_screening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace annulus {
namespace {

constexpr double kMadToSigma = 1.4826;  // sd of a normal distribution over its median absolute deviation

/// Radius in a cell if it holds a sample of verdict good.
class GoodRadius {
 public:
  GoodRadius(std::span<const SurfaceSample> samples, const SampleGrid& grid, std::span<const SampleVerdict> verdicts)
      : samples_(samples), grid_(grid), verdicts_(verdicts) {}

  [[nodiscard]] std::optional<double> At(std::ptrdiff_t row, std::size_t column) const {
    if (row < 0 || row >= static_cast<std::ptrdiff_t>(grid_.rows())) return std::nullopt;
    const std::size_t k = grid_.At(static_cast<std::size_t>(row), column);
    if (k == SampleGrid::kNone || verdicts_[k] != SampleVerdict::kGood) return std::nullopt;
    return samples_[k].radius;
  }

  /// Good radii in the (2h+1)² neighbourhood, the centre excluded.
  [[nodiscard]] std::vector<double> Around(std::size_t row, std::size_t column, std::ptrdiff_t half) const {
    std::vector<double> radii;
    for (std::ptrdiff_t dr = -half; dr <= half; ++dr) {
      for (std::ptrdiff_t dc = -half; dc <= half; ++dc) {
        if (dr == 0 && dc == 0) continue;
        if (const auto r = At(static_cast<std::ptrdiff_t>(row) + dr, grid_.Column(column, dc))) radii.push_back(*r);
      }
    }
    return radii;
  }

 private:
  std::span<const SurfaceSample> samples_;
  const SampleGrid& grid_;
  std::span<const SampleVerdict> verdicts_;
};

/// How far `radius` lies beyond the `rank`-th highest or lowest of `radii` (rank 0 = the extreme itself), mm.
double Beyond(std::vector<double>& radii, std::size_t rank, double radius) {
  std::sort(radii.begin(), radii.end());
  return std::max(radius - radii[radii.size() - 1 - rank], radii[rank] - radius);
}

void MarkOutliers(std::span<const SurfaceSample> samples, const SampleGrid& grid, const ScreeningOptions& options,
                  std::vector<SampleVerdict>& verdicts) {
  std::vector<std::array<std::size_t, 2>> candidates;
  const GoodRadius all(samples, grid, verdicts);
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const auto radius = all.At(static_cast<std::ptrdiff_t>(row), column);
      if (!radius) continue;
      std::vector<double> around = all.Around(row, column, 2);
      const bool alone = around.size() < 4;
      if (alone || Beyond(around, 1, *radius) > options.outlier_candidate_mm) candidates.push_back({row, column});
    }
  }
  // A candidate is confirmed against its neighbours that are not candidates: an edge has company, an outlier has not.
  std::vector<SampleVerdict> without_candidates = verdicts;
  for (const auto& [row, column] : candidates) without_candidates[grid.At(row, column)] = SampleVerdict::kOutlier;
  const GoodRadius sure(samples, grid, without_candidates);
  for (const auto& [row, column] : candidates) {
    const std::size_t k = grid.At(row, column);
    std::vector<double> around = sure.Around(row, column, 1);
    const bool confirmed = around.empty() || Beyond(around, 0, samples[k].radius) > options.outlier_confirm_mm;
    if (confirmed) verdicts[k] = SampleVerdict::kOutlier;
  }
}

/// A run of columns of one row that stands before both its sides.
struct Run {
  std::size_t row = 0;
  std::size_t first = 0;  ///< Position in the list of good columns.
  std::size_t length = 0;
};

/// Columns of a row that hold good samples, in order.
std::vector<std::size_t> GoodColumns(const GoodRadius& good, const SampleGrid& grid, std::size_t row) {
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    if (good.At(static_cast<std::ptrdiff_t>(row), c)) columns.push_back(c);
  }
  return columns;
}

std::vector<Run> ForegroundRuns(const GoodRadius& good, const SampleGrid& grid, std::size_t row,
                                const ScreeningOptions& options) {
  const std::vector<std::size_t> columns = GoodColumns(good, grid, row);
  const std::size_t n = columns.size();
  std::vector<Run> runs;
  if (n < 8) return runs;
  const auto radius = [&](std::size_t k) { return *good.At(static_cast<std::ptrdiff_t>(row), columns[k % n]); };
  for (std::size_t start = 0; start < n; ++start) {
    if (radius(start) - radius(start + n - 1) < options.foreground_step_mm) continue;  // no step up before it
    for (std::size_t length = 1; length < n / 2; ++length) {
      const double step = radius(start + length) - radius(start + length - 1);
      const double width =
          WrapAngle(grid.column_theta(columns[(start + length - 1) % n]) - grid.column_theta(columns[start]));
      if (width > options.foreground_width_rad || step > options.foreground_step_mm) break;
      if (step < -options.foreground_step_mm) {
        runs.push_back({row, start, length});
        break;
      }
    }
  }
  return runs;
}

/// Merges a run into the object it continues (same side, within `gap_mm` above the object's top), or starts a new one.
void MergeRun(double z, double theta, std::size_t samples, double gap_mm, std::vector<ForegroundObject>& objects) {
  for (ForegroundObject& object : objects) {
    if (z - object.z_max <= gap_mm && std::abs(AngleDifference(theta, object.theta)) < 0.35) {
      object.z_max = z;
      object.theta = theta;
      object.samples += samples;
      return;
    }
  }
  objects.push_back({z, z, theta, samples});
}

void MarkForeground(std::span<const SurfaceSample> samples, const SampleGrid& grid, const ScreeningOptions& options,
                    Screening& screening) {
  const std::vector<SampleVerdict> before = screening.verdicts;
  const GoodRadius good(samples, grid, before);
  const double pitch = grid.rows() > 1 ? (grid.row_z(grid.rows() - 1) - grid.row_z(0)) / double(grid.rows() - 1) : 1.0;
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    const std::vector<std::size_t> columns = GoodColumns(good, grid, row);
    for (const Run& run : ForegroundRuns(good, grid, row, options)) {
      for (std::size_t k = 0; k < run.length; ++k) {
        screening.verdicts[grid.At(row, columns[(run.first + k) % columns.size()])] = SampleVerdict::kForeground;
      }
      const std::size_t middle = columns[(run.first + run.length / 2) % columns.size()];
      MergeRun(grid.row_z(row), grid.column_theta(middle), run.length, std::max(20.0, 4.0 * pitch),
               screening.foreground);
    }
  }
}

/// A level on which the run was not seen whole (a dropout or an outlier at its end) still belongs to the object:
/// returns that have foreground at a like radius on two sides are foreground too. One cell only: the shoulder is not
/// eaten away.
void CloseForeground(std::span<const SurfaceSample> samples, const SampleGrid& grid, const ScreeningOptions& options,
                     std::vector<SampleVerdict>& verdicts) {
  const std::vector<SampleVerdict> before = verdicts;
  const auto rows = static_cast<std::ptrdiff_t>(grid.rows());
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const std::size_t k = grid.At(static_cast<std::size_t>(row), column);
      if (k == SampleGrid::kNone || before[k] != SampleVerdict::kGood) continue;
      int like = 0;
      for (std::ptrdiff_t dr = -1; dr <= 1; ++dr) {
        for (std::ptrdiff_t dc = -1; dc <= 1; ++dc) {
          if (row + dr < 0 || row + dr >= rows) continue;
          const std::size_t other = grid.At(static_cast<std::size_t>(row + dr), grid.Column(column, dc));
          if (other == SampleGrid::kNone || before[other] != SampleVerdict::kForeground) continue;
          if (std::abs(samples[other].radius - samples[k].radius) < 0.5 * options.foreground_step_mm) ++like;
        }
      }
      if (like >= 2) verdicts[k] = SampleVerdict::kForeground;
    }
  }
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
  screening.verdicts.assign(samples.size(), SampleVerdict::kGood);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!IsUsable(samples[k])) screening.verdicts[k] = SampleVerdict::kOutlier;
  }
  // Two outliers near each other vouch for each other until one of them is gone: look again.
  constexpr int kMaxPasses = 4;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const std::vector<SampleVerdict> before = screening.verdicts;
    MarkOutliers(samples, grid, options, screening.verdicts);
    if (screening.verdicts == before) break;
  }
  MarkForeground(samples, grid, options, screening);
  if (!screening.foreground.empty()) {
    CloseForeground(samples, grid, options, screening.verdicts);
    MarkOutliers(samples, grid, options, screening.verdicts);  // what is left of an object's edge now stands alone
  }
  return screening;
}

double EstimateNoise(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                     std::span<const SampleVerdict> verdicts) {
  const GoodRadius good(samples, grid, verdicts);
  std::vector<double> along_row;
  std::vector<double> along_column;
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    const auto signed_row = static_cast<std::ptrdiff_t>(row);
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const auto centre = good.At(signed_row, column);
      if (!centre) continue;
      const auto left = good.At(signed_row, grid.Column(column, -1));
      const auto right = good.At(signed_row, grid.Column(column, 1));
      if (left && right) along_row.push_back(std::abs(*left - 2.0 * *centre + *right) / std::sqrt(6.0));
      const auto below = good.At(signed_row - 1, column);
      const auto above = good.At(signed_row + 1, column);
      if (below && above) along_column.push_back(std::abs(*below - 2.0 * *centre + *above) / std::sqrt(6.0));
    }
  }
  constexpr std::size_t kEnough = 30;
  double sigma = std::numeric_limits<double>::infinity();
  if (along_row.size() >= kEnough) sigma = std::min(sigma, kMadToSigma * MedianOf(along_row));
  if (along_column.size() >= kEnough) sigma = std::min(sigma, kMadToSigma * MedianOf(along_column));
  return std::isfinite(sigma) ? sigma : 0.0;
}

}  // namespace annulus
