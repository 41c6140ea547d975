#include "fitting/cell_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kMinColumns = 24;
constexpr std::size_t kMaxColumns = 360;
constexpr std::size_t kMaxRows = 2048;

/// `x` >= 0 rounded to the nearest integer, halves up.
std::size_t RoundUp(double x) {
  const auto whole = static_cast<std::size_t>(x);
  return whole + (x - static_cast<double>(whole) >= 0.5 ? 1 : 0);
}

/// How many rows of the scan lie in a range of heights: its pitch, whatever the number of interleaved sweeps. Where
/// levels are missing, as many as usual gaps fit in count.
std::size_t CountLevels(const SampleGrid& order, double z_min, double z_max) {
  const double same = 1e-4 * (z_max - z_min);
  std::vector<double> gaps;
  double last = -std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < order.rows(); ++row) {
    const double z = order.row_z(row);
    if (z < z_min - 1e-9 || z > z_max + 1e-9 || z - last < same) continue;
    if (std::isfinite(last)) gaps.push_back(z - last);
    last = z;
  }
  if (gaps.empty()) return 1;
  std::vector<double> sorted = gaps;
  const std::size_t place = gaps.size() * 3 / 4;  // sweeps that interleave unevenly leave small gaps and usual ones
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(place), sorted.end());
  double levels = 1.0;
  for (const double gap : gaps) levels += std::max(1.0, std::round(gap / sorted[place]));
  return static_cast<std::size_t>(std::min(levels, static_cast<double>(kMaxRows)));
}

}  // namespace

CellGrid::CellGrid(std::span<const SurfaceSample> samples, const SampleGrid& order,
                   std::span<const SampleVerdict> verdicts) {
  z_min_ = std::numeric_limits<double>::infinity();
  z_max_ = -z_min_;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] != SampleVerdict::kGood) continue;
    z_min_ = std::min(z_min_, samples[k].z);
    z_max_ = std::max(z_max_, samples[k].z);
  }
  ENSURE(z_min_ < z_max_, "good samples span a range of heights");
  columns_ = std::clamp(order.RingSize(), kMinColumns, kMaxColumns);
  theta_step_ = kTwoPi / static_cast<double>(columns_);
  const double total = z_max_ - z_min_;
  rows_ = std::clamp(CountLevels(order, z_min_, z_max_), std::size_t{5}, kMaxRows);
  z_step_ = total / static_cast<double>(rows_ - 1);
  count_.assign(columns_ * rows_, 0);
  mean_.assign(columns_ * rows_, 0.0);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] != SampleVerdict::kGood) continue;
    const std::size_t cell = IndexOf(samples[k]);
    const double above = samples[k].radius - mean_[cell];
    mean_[cell] += ++count_[cell] == 1 ? above : above / static_cast<double>(count_[cell]);
  }
}

std::size_t CellGrid::IndexOf(const SurfaceSample& sample) const {
  const std::size_t column = RoundUp(WrapAngle(sample.theta) / theta_step_);
  const double row = std::clamp((sample.z - z_min_) / z_step_, 0.0, static_cast<double>(rows_ - 1));
  return Index(column < columns_ ? column : 0, RoundUp(row));
}

namespace {

/// Radii of the surface at the cells' centres. The sums over theta are shared by the rows between two knots.
std::vector<double> RadiiAtCells(const CellGrid& cells, const SplineSurface& surface) {
  const std::size_t columns = cells.columns();
  std::vector<CubicBasis> theta(columns);
  for (std::size_t column = 0; column < columns; ++column)
    theta[column] = surface.theta_basis().At(cells.theta(column));
  const std::size_t height = surface.z_basis().count();
  std::vector<double> along(4 * columns);  // coefficient row j summed over theta, at j % 4
  std::array<std::size_t, 4> held{height, height, height, height};
  std::vector<double> radii(columns * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const CubicBasis z = surface.z_basis().At(cells.z(row));
    double* out = radii.data() + row * columns;
    for (std::size_t j = 0; j < 4; ++j) {
      double* sums = along.data() + (z.index[j] % 4) * columns;
      if (held[z.index[j] % 4] != z.index[j]) {
        held[z.index[j] % 4] = z.index[j];
        const double* c = surface.coefficients().data() + z.index[j] * surface.theta_basis().count();
        for (std::size_t k = 0; k < columns; ++k) {
          const auto& [index, value, first, second] = theta[k];
          sums[k] = value[0] * c[index[0]] + value[1] * c[index[1]] + value[2] * c[index[2]] + value[3] * c[index[3]];
        }
      }
      for (std::size_t k = 0; k < columns; ++k) out[k] += z.value[j] * sums[k];
    }
  }
  return radii;
}

/// Calls `visit` with the column and row of the (up to eight) cells around a cell, and the steps to them.
template <class Visit>
void ForNeighbours(const CellGrid& cells, std::size_t cell, Visit visit) {
  const std::size_t row = cell / cells.columns();
  const std::size_t column = cell % cells.columns();
  const std::array<std::size_t, 3> beside{column == 0 ? cells.columns() - 1 : column - 1, column,
                                          column + 1 == cells.columns() ? 0 : column + 1};
  for (std::size_t r = row - std::min<std::size_t>(row, 1); r <= std::min(row + 1, cells.rows() - 1); ++r) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (r != row || k != 1) visit(cells.Index(beside[k], r), k != 1, r != row);
    }
  }
}

/// Distance of every cell from the nearest one with a sample, mm along the surface over the 8-neighbour grid
/// (Dijkstra), or infinity beyond kInferenceReach.
std::vector<double> DistanceFromSamples(const CellGrid& cells, const std::vector<double>& radius) {
  std::vector<double> distance(radius.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto seen = [&](std::size_t cell) { return cells.count(cell % cells.columns(), cell / cells.columns()) > 0; };
  const auto leave = [&](std::size_t cell) {
    ForNeighbours(cells, cell, [&](std::size_t other, bool sideways, bool upwards) {
      if (distance[other] <= distance[cell]) return;
      const double across =
          sideways ? 0.5 * (std::abs(radius[cell]) + std::abs(radius[other])) * cells.theta_step() : 0.0;
      const double up = upwards ? cells.z_step() : 0.0;
      const double out = radius[other] - radius[cell];
      const double reached = distance[cell] + std::sqrt(across * across + up * up + out * out);
      if (reached > kInferenceReach || reached >= distance[other]) return;
      distance[other] = reached;
      queue.emplace(reached, other);
    });
  };
  for (std::size_t cell = 0; cell < distance.size(); ++cell) {
    if (seen(cell)) distance[cell] = 0.0;
  }
  for (std::size_t cell = 0; cell < distance.size(); ++cell) {
    if (distance[cell] == 0.0) leave(cell);
  }
  while (!queue.empty()) {
    const auto [so_far, cell] = queue.top();
    queue.pop();
    if (so_far == distance[cell]) leave(cell);
  }
  return distance;
}

}  // namespace

KnowledgeMap BuildKnowledge(const CellGrid& cells, const SplineSurface& surface) {
  const std::vector<double> distance = DistanceFromSamples(cells, RadiiAtCells(cells, surface));
  const double half = 0.5 * cells.z_step();
  KnowledgeMap map(cells.columns(), cells.rows(), cells.z_min() - half, cells.z_max() + half);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::size_t cell = cells.Index(column, row);
      bool beside = distance[cell] == 0.0;
      if (!beside) ForNeighbours(cells, cell, [&](std::size_t other, bool, bool) { beside |= distance[other] == 0.0; });
      const Knowledge knowledge = beside                              ? Knowledge::kMeasured
                                  : distance[cell] <= kInferenceReach ? Knowledge::kInferred
                                                                      : Knowledge::kUnknown;
      map.SetCell(column, row, knowledge);
    }
  }
  return map;
}

}  // namespace annulus
