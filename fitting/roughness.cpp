#include "fitting/roughness.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr std::ptrdiff_t kHalf = 2;          // of the 5 × 5 window of the local quadratic
constexpr double kVarianceInflation = 12.0;  // prior variance of a second difference over its local mean square
constexpr double kSmallestBend = 0.06;       // mm; no cell is taken to be flatter than this
constexpr double kHoleSlope = 3.0;           // mm per cell; prior sd of the slope where nothing was seen

/// Values on the cells: the mean of the samples, or the pilot where there is none.
struct FilledCells {
  std::vector<double> value;
  std::vector<double> noise_variance;  ///< Of `value`, mm².
};

FilledCells Fill(const CellGrid& cells, const SplineSurface& pilot, double noise_sigma) {
  FilledCells filled;
  filled.value.resize(cells.columns() * cells.rows());
  filled.noise_variance.assign(filled.value.size(), 0.0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::size_t k = cells.Index(column, row);
      const std::uint32_t count = cells.count(column, row);
      filled.value[k] = count > 0 ? cells.mean(column, row) : pilot.Radius(cells.theta(column), cells.z(row));
      if (count > 0) filled.noise_variance[k] = noise_sigma * noise_sigma / static_cast<double>(count);
    }
  }
  return filled;
}

/// Squares of the second differences of the local quadratic, with the variance that noise gives them taken off.
std::vector<CellBend> SquaredBends(const CellGrid& cells, const FilledCells& filled) {
  const auto columns = static_cast<std::ptrdiff_t>(cells.columns());
  const auto rows = static_cast<std::ptrdiff_t>(cells.rows());
  std::vector<CellBend> squares(filled.value.size());
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    const std::ptrdiff_t centre = std::clamp(row, kHalf, rows - 1 - kHalf);
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      CellBend bend;
      CellBend variance;
      for (std::ptrdiff_t dr = -kHalf; dr <= kHalf; ++dr) {
        for (std::ptrdiff_t dc = -kHalf; dc <= kHalf; ++dc) {
          const auto k = static_cast<std::size_t>((centre + dr) * columns + (column + dc + columns) % columns);
          // Least squares over the window: y ≈ … + ½ uu·dc² + uv·dc·dr + ½ vv·dr².
          const double uu = static_cast<double>(dc * dc - 2) / 35.0;
          const double vv = static_cast<double>(dr * dr - 2) / 35.0;
          const double uv = static_cast<double>(dc * dr) / 100.0;
          bend.uu += uu * filled.value[k];
          bend.vv += vv * filled.value[k];
          bend.uv += uv * filled.value[k];
          variance.uu += uu * uu * filled.noise_variance[k];
          variance.vv += vv * vv * filled.noise_variance[k];
          variance.uv += uv * uv * filled.noise_variance[k];
        }
      }
      squares[static_cast<std::size_t>(row * columns + column)] = {
          bend.uu * bend.uu - variance.uu, bend.vv * bend.vv - variance.vv, bend.uv * bend.uv - variance.uv};
    }
  }
  return squares;
}

/// Mean over a window of (2·half_rows+1) × (2·half_columns+1) cells, cyclic in columns.
std::vector<double> WindowMean(const CellGrid& cells, const std::vector<double>& values, std::ptrdiff_t half_rows,
                               std::ptrdiff_t half_columns) {
  const auto columns = static_cast<std::ptrdiff_t>(cells.columns());
  const auto rows = static_cast<std::ptrdiff_t>(cells.rows());
  std::vector<double> across(values.size());
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      double sum = 0.0;
      for (std::ptrdiff_t d = -half_columns; d <= half_columns; ++d) {
        sum += values[static_cast<std::size_t>(row * columns + (column + d + columns) % columns)];
      }
      across[static_cast<std::size_t>(row * columns + column)] = sum / static_cast<double>(2 * half_columns + 1);
    }
  }
  std::vector<double> mean(values.size());
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, row - half_rows);
    const std::ptrdiff_t last = std::min(rows - 1, row + half_rows);
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      double sum = 0.0;
      for (std::ptrdiff_t r = first; r <= last; ++r) sum += across[static_cast<std::size_t>(r * columns + column)];
      mean[static_cast<std::size_t>(row * columns + column)] = sum / static_cast<double>(last - first + 1);
    }
  }
  return mean;
}

}  // namespace

RoughnessWeights ThinPlateWeights(const CellGrid& cells, double mean_radius, double lambda) {
  const double ds = mean_radius * cells.theta_step();
  const double dz = cells.z_step();
  const double area = ds * dz;
  const CellBend weight{lambda * area / (ds * ds * ds * ds), lambda * area / (dz * dz * dz * dz),
                        2.0 * lambda * area / (ds * ds * dz * dz)};
  return {std::vector<CellBend>(cells.columns() * cells.rows(), weight)};
}

StencilMatrix RoughnessMatrix(const PeriodicCubicBasis& theta, const ClampedCubicBasis& z, const CellGrid& cells,
                              const RoughnessWeights& weights) {
  StencilMatrix matrix(theta.count(), z.count());
  const double uu_scale = std::pow(cells.theta_step(), 4);
  const double vv_scale = std::pow(cells.z_step(), 4);
  const double uv_scale = std::pow(cells.theta_step() * cells.z_step(), 2);
  std::vector<CubicBasis> theta_at(cells.columns());
  for (std::size_t column = 0; column < cells.columns(); ++column) theta_at[column] = theta.At(cells.theta(column));
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const CubicBasis v = z.At(cells.z(row));
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const CubicBasis& u = theta_at[column];
      const CellBend& w = weights.cells[cells.Index(column, row)];
      matrix.AddOuter(u, u.second, v, v.value, w.uu * uu_scale);
      matrix.AddOuter(u, u.value, v, v.second, w.vv * vv_scale);
      matrix.AddOuter(u, u.first, v, v.first, w.uv * uv_scale);
    }
  }
  return matrix;
}

StencilMatrix HoleMatrix(const PeriodicCubicBasis& theta, const ClampedCubicBasis& z, const CellGrid& cells) {
  StencilMatrix matrix(theta.count(), z.count());
  const double theta_weight = std::pow(cells.theta_step() / kHoleSlope, 2);
  const double z_weight = std::pow(cells.z_step() / kHoleSlope, 2);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const CubicBasis v = z.At(cells.z(row));
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      if (cells.count(column, row) > 0) continue;
      const CubicBasis u = theta.At(cells.theta(column));
      matrix.AddOuter(u, u.first, v, v.value, theta_weight);
      matrix.AddOuter(u, u.value, v, v.first, z_weight);
    }
  }
  return matrix;
}

RoughnessWeights LocalWeights(const CellGrid& cells, const SplineSurface& pilot, double noise_sigma) {
  const std::vector<CellBend> squares = SquaredBends(cells, Fill(cells, pilot, noise_sigma));
  const auto component = [&](double CellBend::*member) {
    std::vector<double> values(squares.size());
    for (std::size_t k = 0; k < squares.size(); ++k) values[k] = squares[k].*member;
    return values;
  };
  // Windows are longer across the direction of the difference: creases run that way.
  const std::vector<double> uu = WindowMean(cells, component(&CellBend::uu), 3, 2);
  const std::vector<double> vv = WindowMean(cells, component(&CellBend::vv), 2, 3);
  const std::vector<double> uv = WindowMean(cells, component(&CellBend::uv), 2, 2);
  const auto weight = [](double mean_square) {
    return 1.0 / (kVarianceInflation * std::max(mean_square, 0.0) + kSmallestBend * kSmallestBend);
  };
  RoughnessWeights weights;
  weights.cells.resize(squares.size());
  for (std::size_t k = 0; k < squares.size(); ++k) weights.cells[k] = {weight(uu[k]), weight(vv[k]), weight(uv[k])};
  return weights;
}

}  // namespace annulus
