#include "fitting/residual_maps.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

constexpr double kUnresolved = 3.5;  // standard deviations of a window's sum

/// Sums over windows of 2·half + 1 cells, cyclic in columns, cut off at the first and last row.
std::vector<double> SumAcross(const CellGrid& cells, const std::vector<double>& values, std::size_t half) {
  const std::size_t columns = cells.columns();
  std::vector<double> sums(values.size());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const double* from = values.data() + row * columns;
    double* to = sums.data() + row * columns;
    for (std::size_t column = 0; column < columns; ++column) {
      for (std::size_t k = columns - half; k <= columns + half; ++k) to[column] += from[(column + k) % columns];
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

/// The largest value over such a window.
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
  const std::size_t columns = cells.columns();
  std::vector<double> scale_of_cell(maps.sum.size(), 1.0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const std::size_t last = std::min(cells.rows() - 1, row + 2);
    for (std::size_t column = 0; column < columns; ++column) {
      double squares = 0.0;
      double count = 0.0;
      std::size_t worst = cells.Index(column, row);
      for (std::size_t r = row - std::min<std::size_t>(row, 2); r <= last; ++r) {
        for (std::size_t d = columns - 2; d <= columns + 2; ++d) {
          const std::size_t k = cells.Index((column + d) % columns, r);
          squares += maps.squares[k];
          count += maps.count[k];
          if (maps.squares[k] > maps.squares[worst]) worst = k;
        }
      }
      squares -= maps.squares[worst];
      count -= maps.count[worst];
      const double rms = count > 0.0 ? std::sqrt(squares / count) : 0.0;
      scale_of_cell[cells.Index(column, row)] = std::max(1.0, rms / input.noise);
    }
  }
  std::vector<double> scales;
  scales.reserve(system.rows().size());
  for (const SampleRow& row : system.rows()) scales.push_back(scale_of_cell[row.cell]);
  return scales;
}

std::vector<char> UnresolvedCells(const FitInput& input, const ResidualMaps& residuals) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kHalves{{{0, 0}, {1, 1}, {0, 2}, {2, 0}, {0, 1}, {1, 0}}};
  const CellGrid& cells = input.cells;
  std::vector<char> unresolved(residuals.sum.size(), 0);
  for (const auto& [half_rows, half_columns] : kHalves) {
    const std::vector<double> sum = SumUp(cells, SumAcross(cells, residuals.sum, half_columns), half_rows);
    const std::vector<double> count = SumUp(cells, SumAcross(cells, residuals.count, half_columns), half_rows);
    const double limit = kUnresolved * kUnresolved * input.noise * input.noise;
    std::vector<char> beyond(sum.size());
    for (std::size_t k = 0; k < sum.size(); ++k) beyond[k] = sum[k] * sum[k] > limit * count[k] ? 1 : 0;
    const std::vector<char> window = Spread(cells, beyond, half_rows, half_columns);
    for (std::size_t k = 0; k < window.size(); ++k) {
      if (window[k] != 0 && residuals.count[k] > 0.0) unresolved[k] = 1;
    }
  }
  return unresolved;
}

}  // namespace annulus
