#include "fitting/residual_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace annulus {
namespace {

constexpr double kSeed = 3.8;              // standard deviations of a window's sum: detail for certain
constexpr double kSpread = 2.0;            // of a window about a cell beside detail: it goes on there
constexpr double kUsualCells = 180 * 360;  // a scan with more cells has no more false alarms than one with so many

/// Sums over windows of 2·half + 1 cells, cyclic in columns, cut off at the first and last row.
std::vector<double> SumAcross(const CellGrid& cells, const std::vector<double>& values, std::size_t half) {
  const std::size_t columns = cells.columns();
  std::vector<double> sums(values.size());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const double* from = values.data() + row * columns;
    double* to = sums.data() + row * columns;
    for (std::size_t column = 0; column < half; ++column) {
      for (std::size_t k = columns - half; k <= columns + half; ++k) {
        to[column] += from[(column + k) % columns];
        to[columns - 1 - column] += from[(columns - 1 - column + k) % columns];
      }
    }
    for (std::size_t k = 0; k <= 2 * half; ++k) {
      for (std::size_t column = half; column + half < columns; ++column) to[column] += from[column + k - half];
    }
  }
  return sums;
}

std::vector<double> SumUp(const CellGrid& cells, const std::vector<double>& values, std::size_t half) {
  const std::size_t columns = cells.columns();
  std::vector<double> sums(values.size());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const std::size_t last = std::min(cells.rows() - 1, row + half);
    double* to = sums.data() + row * columns;
    for (std::size_t r = row - std::min(row, half); r <= last; ++r) {
      const double* from = values.data() + r * columns;
      for (std::size_t column = 0; column < columns; ++column) to[column] += from[column];
    }
  }
  return sums;
}

/// The cell with the largest value in the 5 × 5 cells around every cell.
std::vector<std::uint32_t> WorstAround(const CellGrid& cells, const std::vector<double>& values) {
  const std::size_t columns = cells.columns();
  std::vector<std::uint32_t> across(values.size());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      auto worst = static_cast<std::uint32_t>(row * columns + column);
      const bool inside = column >= 2 && column + 2 < columns;
      for (std::size_t k = columns - 2; k <= columns + 2; ++k) {
        const std::size_t other = row * columns + (inside ? column + k - columns : (column + k) % columns);
        if (values[other] > values[worst]) worst = static_cast<std::uint32_t>(other);
      }
      across[row * columns + column] = worst;
    }
  }
  std::vector<std::uint32_t> around = across;
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const std::size_t last = std::min(cells.rows() - 1, row + 2);
    for (std::size_t r = row - std::min<std::size_t>(row, 2); r <= last; ++r) {
      for (std::size_t column = 0; column < columns; ++column) {
        std::uint32_t& worst = around[row * columns + column];
        const std::uint32_t other = across[r * columns + column];
        if (values[other] > values[worst]) worst = other;
      }
    }
  }
  return around;
}

/// The largest flag over such a window.
std::vector<char> Spread(const CellGrid& cells, const std::vector<char>& flags, std::size_t half_rows,
                         std::size_t half_columns) {
  const std::size_t columns = cells.columns();
  std::vector<char> spread(flags.size(), 0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      if (flags[cells.Index(column, row)] == 0) continue;
      const std::size_t last = std::min(cells.rows() - 1, row + half_rows);
      for (std::size_t r = row - std::min(row, half_rows); r <= last; ++r) {
        for (std::size_t k = columns - half_columns; k <= columns + half_columns; ++k) {
          spread[r * columns + (column + k) % columns] = 1;
        }
      }
    }
  }
  return spread;
}

}  // namespace

ResidualMaps CollectResiduals(const FitInput& input, const SplineSystem& system, const Eigen::VectorXd& residuals) {
  const std::size_t n = input.cells.columns() * input.cells.rows();
  ResidualMaps maps{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t k = 0; k < system.rows().size(); ++k) {
    const std::size_t cell = system.rows()[k].cell;
    const double residual = residuals[static_cast<Eigen::Index>(k)];
    maps.sum[cell] += residual;
    maps.squares[cell] += residual * residual;
    maps.count[cell] += 1.0;
  }
  return maps;
}

std::vector<double> LocalScales(const FitInput& input, const SplineSystem& system, const Eigen::VectorXd& residuals) {
  const ResidualMaps maps = CollectResiduals(input, system, residuals);
  const CellGrid& cells = input.cells;
  const std::vector<double> squares = SumUp(cells, SumAcross(cells, maps.squares, 2), 2);
  const std::vector<double> count = SumUp(cells, SumAcross(cells, maps.count, 2), 2);
  const std::vector<std::uint32_t> worst = WorstAround(cells, maps.squares);
  std::vector<double> scale_of_cell(maps.sum.size(), 1.0);
  for (std::size_t k = 0; k < scale_of_cell.size(); ++k) {
    const double others = count[k] - maps.count[worst[k]];
    if (others <= 0.0) continue;
    const double mean_square = std::max(0.0, squares[k] - maps.squares[worst[k]]) / others;
    scale_of_cell[k] = std::max(1.0, std::sqrt(mean_square) / input.noise);
  }
  std::vector<double> scales;
  scales.reserve(system.rows().size());
  for (const SampleRow& row : system.rows()) scales.push_back(scale_of_cell[row.cell]);
  return scales;
}

std::vector<std::uint32_t> LoneSamples(const FitInput& input, const SplineSystem& system,
                                       const Eigen::VectorXd& residuals) {
  constexpr double kFarOff = 5.0;      // mm
  constexpr double kManyScales = 8.0;  // of the residuals around
  std::vector<std::uint32_t> lone;
  const std::vector<double> scales = LocalScales(input, system, residuals);
  for (std::size_t k = 0; k < system.rows().size(); ++k) {
    const double size = std::abs(residuals[static_cast<Eigen::Index>(k)]);
    if (size > kFarOff && size > kManyScales * scales[k] * input.noise) lone.push_back(system.rows()[k].sample);
  }
  return lone;
}

namespace {

/// Adds to `flags` the cells of `more` that hang together with them (8 neighbours, cyclic in columns).
std::vector<char> Grown(const CellGrid& cells, std::vector<char> flags, const std::vector<char>& more) {
  const std::size_t columns = cells.columns();
  std::vector<std::size_t> open;
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k] != 0) open.push_back(k);
  }
  while (!open.empty()) {
    const std::size_t row = open.back() / columns;
    const std::size_t column = open.back() % columns;
    open.pop_back();
    for (std::size_t r = row - std::min<std::size_t>(row, 1); r <= std::min(row + 1, cells.rows() - 1); ++r) {
      for (std::size_t step = columns - 1; step <= columns + 1; ++step) {
        const std::size_t other = r * columns + (column + step) % columns;
        if (more[other] == 0 || flags[other] != 0) continue;
        flags[other] = 1;
        open.push_back(other);
      }
    }
  }
  return flags;
}

}  // namespace

std::vector<char> UnresolvedCells(const FitInput& input, const ResidualMaps& residuals) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kHalves{{{0, 0}, {1, 1}, {0, 2}, {2, 0}, {0, 1}, {1, 0}}};
  const CellGrid& cells = input.cells;
  // The tail of the normal distribution beyond k falls about as exp(-k²/2).
  const double crowd = 2.0 * std::log(std::max(1.0, static_cast<double>(residuals.sum.size()) / kUsualCells));
  const double variance = input.noise * input.noise;
  std::vector<char> certain(residuals.sum.size(), 0);
  std::vector<char> likely(residuals.sum.size(), 0);
  for (const auto& [half_rows, half_columns] : kHalves) {
    const std::vector<double> sum = SumUp(cells, SumAcross(cells, residuals.sum, half_columns), half_rows);
    const std::vector<double> count = SumUp(cells, SumAcross(cells, residuals.count, half_columns), half_rows);
    const bool single = half_rows + half_columns == 0;
    std::vector<char> beyond(sum.size());
    for (std::size_t k = 0; k < sum.size(); ++k) {
      beyond[k] = sum[k] * sum[k] > (kSeed * kSeed + crowd) * variance * count[k] ? 1 : 0;
      if (!single && sum[k] * sum[k] > (kSpread * kSpread + crowd) * variance * count[k]) likely[k] = 1;
    }
    const std::vector<char> window = Spread(cells, beyond, half_rows, half_columns);
    for (std::size_t k = 0; k < window.size(); ++k) {
      if (window[k] != 0) certain[k] = 1;
    }
  }
  for (std::size_t k = 0; k < certain.size(); ++k) {
    if (residuals.count[k] == 0.0) certain[k] = likely[k] = 0;
  }
  return Grown(cells, std::move(certain), likely);
}

}  // namespace annulus
