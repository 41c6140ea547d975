#include "modeling/landmarks/ear_outline.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/units.h"
#include "modeling/landmarks/weighted_mean.h"

namespace annulus {
namespace {

/// How far the ear stands out of the head: the surface less its morphological opening around (features narrower than
/// 45° removed), on a window of degrees counted from the side's middle, forward positive.
class EarRelief {
 public:
  static constexpr int kBack = -56;
  static constexpr int kFront = 35;

  EarRelief(const HeadGrid& grid, BodySide side) : grid_(grid), side_(side) {}

  [[nodiscard]] int Degree(int forward) const { return side_ == BodySide::kRight ? forward : 180 - forward; }
  /// The head without the ear, mm from the axis, one value per degree from kBack to kFront.
  [[nodiscard]] std::vector<double> Base(int row) const {
    constexpr int kHalf = 22;
    std::vector<double> row_radius;
    for (int forward = kBack - 2 * kHalf; forward <= kFront + 2 * kHalf; ++forward) {
      row_radius.push_back(grid_.r(Degree(forward), row));
    }
    std::vector<double> eroded;
    for (auto start = row_radius.begin(); start + 2 * kHalf < row_radius.end(); ++start) {
      eroded.push_back(*std::min_element(start, start + 2 * kHalf + 1));
    }
    std::vector<double> opened;
    for (auto start = eroded.begin(); start + 2 * kHalf < eroded.end(); ++start) {
      opened.push_back(*std::max_element(start, start + 2 * kHalf + 1));
    }
    return opened;
  }
  [[nodiscard]] std::vector<double> Height(int row) const {
    std::vector<double> height = Base(row);
    for (std::size_t k = 0; k < height.size(); ++k) {
      height[k] = grid_.r(Degree(kBack + static_cast<int>(k)), row) - height[k];
    }
    return height;
  }

 private:
  const HeadGrid& grid_;
  BodySide side_;
};

/// The ear's relief, row by row downwards, only near the column in which it stands out most: the cheek's hollows far in
/// front of the ear also make some relief.
std::vector<std::vector<double>> EarOnly(const EarRelief& relief, int first, int last) {
  constexpr std::size_t kReach = 20;
  std::vector<std::vector<double>> heights;
  for (int row = first; row <= last; ++row) heights.push_back(relief.Height(row));
  std::vector<double> columns(heights.front().size(), 0.0);
  for (const std::vector<double>& row : heights) {
    for (std::size_t k = 0; k < row.size(); ++k) columns[k] += row[k];
  }
  const auto ear = static_cast<std::size_t>(std::max_element(columns.begin(), columns.end()) - columns.begin());
  for (std::vector<double>& row : heights) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (k + kReach < ear || k > ear + kReach) row[k] = 0.0;
    }
  }
  return heights;
}

/// The rows that the ear takes, counted from the first row searched.
struct EarRows {
  std::size_t upper;
  std::size_t lower;
  double top;     ///< Where the relief ends above, in rows, between them.
  double bottom;  ///< And below.
  double edge;    ///< mm; the relief at which it ends.
  double peak;    ///< mm; its largest relief.
};

/// From the row where the ear is largest up and down until it stands out by a fifth of its height only. Empty if that
/// is nothing like an ear.
std::optional<EarRows> FindEarRows(const std::vector<std::vector<double>>& heights) {
  constexpr double kLeastEar = 4.0;
  constexpr double kLeastEdge = 2.0;
  constexpr std::size_t kShortest = 20;
  constexpr std::size_t kLongest = 100;
  std::vector<double> peaks;
  std::vector<double> sums;
  for (const std::vector<double>& row : heights) {
    peaks.push_back(*std::max_element(row.begin(), row.end()));
    sums.push_back(std::accumulate(row.begin(), row.end(), 0.0));
  }
  const double peak = *std::max_element(peaks.begin(), peaks.end());
  const auto middle = static_cast<std::size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  EarRows rows{middle, middle, 0.0, 0.0, std::max(0.2 * peak, kLeastEdge), peak};
  while (rows.upper > 0 && peaks[rows.upper - 1] >= rows.edge) --rows.upper;
  while (rows.lower + 1 < peaks.size() && peaks[rows.lower + 1] >= rows.edge) ++rows.lower;
  const std::size_t length = rows.lower - rows.upper;
  if (peak < kLeastEar || length < kShortest || length > kLongest || rows.upper == 0) return std::nullopt;
  const auto beyond = [&](std::size_t inside, std::size_t outside) {
    const double fall = peaks[inside] - peaks[outside];
    return fall > 0.0 ? std::clamp((peaks[inside] - rows.edge) / fall, 0.0, 1.0) : 0.0;
  };
  rows.top = static_cast<double>(rows.upper) - beyond(rows.upper, rows.upper - 1);
  rows.bottom = static_cast<double>(rows.lower) + beyond(rows.lower, std::min(rows.lower + 1, peaks.size() - 1));
  return rows;
}

/// The ear's middle, degrees forward: centroid of its relief in all its rows.
double MiddleOf(const std::vector<std::vector<double>>& heights, const EarRows& rows) {
  WeightedMean middle;
  for (std::size_t row = rows.upper; row <= rows.lower; ++row) {
    for (std::size_t k = 0; k < heights[row].size(); ++k) {
      middle.Add(std::max(heights[row][k] - rows.edge, 0.0), EarRelief::kBack + static_cast<double>(k));
    }
  }
  return middle.value();
}

/// Where the relief begins coming from the face, degrees forward: median of the rows from 0.35 to 0.55 of the ear's
/// height below its top.
double FrontOf(const std::vector<std::vector<double>>& heights, const EarRows& rows, double middle) {
  const auto length = static_cast<double>(rows.lower - rows.upper);
  const std::size_t first = rows.upper + static_cast<std::size_t>(0.35 * length);
  const std::size_t last = rows.upper + static_cast<std::size_t>(0.55 * length);
  std::vector<double> fronts;
  for (std::size_t row = first; row <= last; ++row) {
    const std::vector<double>& height = heights[row];
    const auto nearest = static_cast<std::size_t>(std::lround(middle - EarRelief::kBack));
    std::size_t k = height.size() - 1;
    while (k > nearest && height[k] < rows.edge) --k;
    // Linear between the ear's first column and the one before it.
    const double next = k + 1 < height.size() ? height[k + 1] : rows.edge;
    const double share = height[k] > next ? std::clamp((height[k] - rows.edge) / (height[k] - next), 0.0, 1.0) : 0.0;
    fronts.push_back(EarRelief::kBack + static_cast<double>(k) + share);
  }
  const auto centre = fronts.begin() + static_cast<std::ptrdiff_t>(fronts.size() / 2);
  std::nth_element(fronts.begin(), centre, fronts.end());
  return *centre;
}

}  // namespace

std::optional<EarOutline> FindEarOutline(const HeadGrid& grid, BodySide side, double highest, double lowest) {
  const EarRelief relief(grid, side);
  const int first = grid.RowAt(highest);
  const std::vector<std::vector<double>> heights = EarOnly(relief, first, grid.RowAt(lowest));
  const std::optional<EarRows> rows = FindEarRows(heights);
  if (!rows) return std::nullopt;
  WeightedMean forward;
  const std::vector<double>& top = heights[rows->upper];
  for (std::size_t k = 0; k < top.size(); ++k) {
    forward.Add(std::max(top[k] - 0.5 * rows->edge, 0.0), EarRelief::kBack + static_cast<double>(k));
  }
  const auto radians = [&](double degrees) {
    return RadiansFromDegrees(side == BodySide::kRight ? degrees : 180.0 - degrees);
  };
  const int row = first + static_cast<int>(rows->upper);
  const auto degree = static_cast<int>(std::lround(forward.value()));
  const double base = relief.Base(row)[static_cast<std::size_t>(degree - EarRelief::kBack)];
  EarOutline ear;
  ear.side = side;
  ear.top_z = grid.z(first) - rows->top;
  ear.bottom_z = grid.z(first) - rows->bottom;
  ear.height = rows->peak;
  ear.top_theta = radians(forward.value());
  ear.top_radius = std::min(grid.r(relief.Degree(degree), row), base + rows->edge);
  const double middle = MiddleOf(heights, *rows);
  ear.middle_theta = radians(middle);
  ear.front_theta = radians(FrontOf(heights, *rows, middle));
  return ear;
}

}  // namespace annulus
