#include "fitting/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kMinColumns = 24;
constexpr std::size_t kMaxColumns = 720;
constexpr std::size_t kMaxRows = 4096;

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
  columns_ = std::clamp(order.columns(), kMinColumns, kMaxColumns);
  theta_step_ = kTwoPi / static_cast<double>(columns_);
  // Rows of the scan that lie in the range: the pitch, whatever the number of interleaved sweeps.
  std::size_t levels = 0;
  double last = -std::numeric_limits<double>::infinity();
  const double total = z_max_ - z_min_;
  for (std::size_t row = 0; row < order.rows(); ++row) {
    const double z = order.row_z(row);
    if (z < z_min_ - 1e-9 || z > z_max_ + 1e-9 || z - last < 1e-4 * total) continue;
    last = z;
    ++levels;
  }
  rows_ = std::clamp(levels, std::size_t{5}, kMaxRows);
  z_step_ = total / static_cast<double>(rows_ - 1);
  count_.assign(columns_ * rows_, 0);
  mean_.assign(columns_ * rows_, 0.0);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] != SampleVerdict::kGood) continue;
    const std::size_t cell = IndexOf(samples[k]);
    ++count_[cell];
    mean_[cell] += (samples[k].radius - mean_[cell]) / static_cast<double>(count_[cell]);
  }
}

std::size_t CellGrid::IndexOf(const SurfaceSample& sample) const {
  const auto column = static_cast<std::size_t>(std::lround(WrapAngle(sample.theta) / theta_step_)) % columns_;
  const double row = std::round((sample.z - z_min_) / z_step_);
  return Index(column, static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows_ - 1))));
}

KnowledgeMap BuildKnowledge(const CellGrid& cells, const SplineSurface& surface) {
  // Dijkstra from all cells with samples over the 8-neighbour grid, with lengths on the surface.
  const std::size_t n = cells.columns() * cells.rows();
  std::vector<double> distance(n, std::numeric_limits<double>::infinity());
  std::vector<double> radius(n);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::size_t k = cells.Index(column, row);
      radius[k] = surface.Radius(cells.theta(column), cells.z(row));
      if (cells.count(column, row) > 0) {
        distance[k] = 0.0;
        queue.emplace(0.0, k);
      }
    }
  }
  while (!queue.empty()) {
    const auto [so_far, k] = queue.top();
    queue.pop();
    if (so_far > distance[k] || so_far > kInferenceReach) continue;
    const auto row = static_cast<std::ptrdiff_t>(k / cells.columns());
    const auto column = static_cast<std::ptrdiff_t>(k % cells.columns());
    for (std::ptrdiff_t dr = -1; dr <= 1; ++dr) {
      for (std::ptrdiff_t dc = -1; dc <= 1; ++dc) {
        const std::ptrdiff_t r = row + dr;
        if ((dr == 0 && dc == 0) || r < 0 || r >= static_cast<std::ptrdiff_t>(cells.rows())) continue;
        const auto width = static_cast<std::ptrdiff_t>(cells.columns());
        const auto other = static_cast<std::size_t>(r * width + (column + dc + width) % width);
        const double across = 0.5 * (std::abs(radius[k]) + std::abs(radius[other])) * cells.theta_step() * double(dc);
        const double step = std::hypot(across, cells.z_step() * double(dr), radius[other] - radius[k]);
        if (so_far + step < distance[other]) {
          distance[other] = so_far + step;
          queue.emplace(distance[other], other);
        }
      }
    }
  }
  const double half = 0.5 * cells.z_step();
  KnowledgeMap map(cells.columns(), cells.rows(), cells.z_min() - half, cells.z_max() + half);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      bool beside = false;
      for (std::ptrdiff_t dr = -1; dr <= 1; ++dr) {
        for (std::size_t dc = 0; dc < 3; ++dc) {
          const auto r = static_cast<std::ptrdiff_t>(row) + dr;
          if (r < 0 || r >= static_cast<std::ptrdiff_t>(cells.rows())) continue;
          const std::size_t c = (column + cells.columns() + dc - 1) % cells.columns();
          beside = beside || cells.count(c, static_cast<std::size_t>(r)) > 0;
        }
      }
      const std::size_t k = cells.Index(column, row);
      const Knowledge knowledge = beside                           ? Knowledge::kMeasured
                                  : distance[k] <= kInferenceReach ? Knowledge::kInferred
                                                                   : Knowledge::kUnknown;
      map.SetCell(column, row, knowledge);
    }
  }
  return map;
}

}  // namespace annulus
