#include "fitting/ring_table.h"

#include <algorithm>
#include <map>

#include "base/frames.h"

namespace annulus {
namespace {

/// Distance of rows below which they are one, mm.
double SameHeight(std::span<const SurfaceSample> samples, const SampleGrid& grid) {
  constexpr double kShare = 0.2;
  std::map<std::uint16_t, std::size_t> rows_of_sweep;
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const std::size_t k = grid.At(row, column);
      if (k == SampleGrid::kNone) continue;
      ++rows_of_sweep[samples[k].sweep];
      break;
    }
  }
  std::size_t most = 1;
  for (const auto& [sweep, rows] : rows_of_sweep) most = std::max(most, rows);
  const double height = grid.rows() > 0 ? grid.row_z(grid.rows() - 1) - grid.row_z(0) : 0.0;
  return kShare * height / static_cast<double>(most);
}

}  // namespace

RingTable BuildRingTable(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                         std::span<const SampleVerdict> verdicts) {
  RingTable table;
  for (std::size_t column = 0; column < grid.columns(); ++column) table.theta.push_back(grid.column_theta(column));
  std::vector<std::vector<std::size_t>> groups;  // of the grid's rows
  const double same = SameHeight(samples, grid);
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    if (groups.empty() || grid.row_z(row) - grid.row_z(groups.back().front()) > same) groups.emplace_back();
    groups.back().push_back(row);
  }
  const auto columns = static_cast<Eigen::Index>(grid.columns());
  table.radius = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(groups.size()), columns);
  table.weight = table.radius;
  for (const std::vector<std::size_t>& group : groups) {
    const auto at = static_cast<Eigen::Index>(table.z.size());
    double z = 0.0;
    for (const std::size_t row : group) {
      z += grid.row_z(row) / static_cast<double>(group.size());
      for (Eigen::Index column = 0; column < columns; ++column) {
        const std::size_t k = grid.At(row, static_cast<std::size_t>(column));
        if (k == SampleGrid::kNone || verdicts[k] != SampleVerdict::kGood) continue;
        const auto weight = static_cast<double>(samples[k].weight);
        table.radius(at, column) += weight * samples[k].radius;
        table.weight(at, column) += weight;
      }
    }
    table.z.push_back(z);
  }
  for (Eigen::Index k = 0; k < table.radius.size(); ++k) {
    if (table.weight(k) > 0.0) table.radius(k) /= table.weight(k);
  }
  return table;
}

std::vector<char> CompleteRows(const RingTable& table, double widest_gap) {
  std::vector<char> complete;
  for (Eigen::Index row = 0; row < table.weight.rows(); ++row) {
    std::vector<double> seen;
    for (std::size_t column = 0; column < table.theta.size(); ++column) {
      if (table.weight(row, static_cast<Eigen::Index>(column)) > 0.0) seen.push_back(table.theta[column]);
    }
    double widest = seen.empty() ? kTwoPi : seen.front() + kTwoPi - seen.back();
    for (std::size_t k = 1; k < seen.size(); ++k) widest = std::max(widest, seen[k] - seen[k - 1]);
    complete.push_back(widest < widest_gap ? 1 : 0);
  }
  return complete;
}

RowRange LongestRange(const std::vector<char>& complete, std::size_t most_missing) {
  RowRange best;
  RowRange current;
  for (std::size_t row = 0; row < complete.size(); ++row) {
    if (complete[row] == 0) continue;
    const bool continues = current.end > 0 && row - current.end <= most_missing;
    current = {continues ? current.begin : row, row + 1};
    if (current.end - current.begin > best.end - best.begin) best = current;
  }
  return best;
}

}  // namespace annulus
