#include "fitting/roughness.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr std::ptrdiff_t kHalf = 2;          // of the 5 × 5 window of the local quadratic
constexpr double kVarianceInflation = 16.0;  // prior variance of a second difference over its local mean square
constexpr double kSmallestBend = 0.10;       // mm; no cell is taken to be flatter than this
constexpr double kHoleSlope = 3.0;           // mm per cell; prior sd of the slope where nothing was seen

/// The local splines at one place.
struct LocalBases {
  std::size_t leaf = 0;
  CubicBasis theta;
  CubicBasis z;
};

LocalBases BasesAt(const HierarchicalSpline& basis, double theta, double z) {
  LocalBases at;
  at.leaf = basis.LeafAt(theta, z);
  const SplineLeaf& leaf = basis.leaves()[at.leaf];
  const SplineLevel& level = basis.levels()[leaf.level];
  at.theta = level.theta.InInterval(leaf.theta_cell, theta);
  at.z = level.z.InInterval(leaf.z_cell, z);
  return at;
}

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

LeafForms RoughnessForms(const HierarchicalSpline& basis, const CellGrid& cells, const RoughnessWeights& weights) {
  LeafForms forms(basis);
  const double uu_scale = std::pow(cells.theta_step(), 4);
  const double vv_scale = std::pow(cells.z_step(), 4);
  const double uv_scale = std::pow(cells.theta_step() * cells.z_step(), 2);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const LocalBases at = BasesAt(basis, cells.theta(column), cells.z(row));
      const CellBend& w = weights.cells[cells.Index(column, row)];
      forms.AddOuter(at.leaf, at.theta.second, at.z.value, w.uu * uu_scale);
      forms.AddOuter(at.leaf, at.theta.value, at.z.second, w.vv * vv_scale);
      forms.AddOuter(at.leaf, at.theta.first, at.z.first, w.uv * uv_scale);
    }
  }
  return forms;
}

LeafForms HoleForms(const HierarchicalSpline& basis, const CellGrid& cells) {
  LeafForms forms(basis);
  const double theta_weight = std::pow(cells.theta_step() / kHoleSlope, 2);
  const double z_weight = std::pow(cells.z_step() / kHoleSlope, 2);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      if (cells.count(column, row) > 0) continue;
      const LocalBases at = BasesAt(basis, cells.theta(column), cells.z(row));
      forms.AddOuter(at.leaf, at.theta.first, at.z.value, theta_weight);
      forms.AddOuter(at.leaf, at.theta.value, at.z.first, z_weight);
    }
  }
  return forms;
}

/// Squared second differences between direct neighbours, kept only where they stand out of the noise: steps and edges.
std::vector<CellBend> SquaredSteps(const CellGrid& cells, const FilledCells& filled, double noise_sigma) {
  constexpr double kStandsOut = 5.0;  // noise standard deviations
  const auto columns = static_cast<std::ptrdiff_t>(cells.columns());
  const auto rows = static_cast<std::ptrdiff_t>(cells.rows());
  const auto square_if_step = [&](double difference, double factor) {
    const double threshold = kStandsOut * factor * noise_sigma;
    return std::abs(difference) > threshold ? difference * difference : 0.0;
  };
  std::vector<CellBend> steps(filled.value.size());
  for (std::ptrdiff_t row = 1; row + 1 < rows; ++row) {
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      const auto at = [&](std::ptrdiff_t dr, std::ptrdiff_t dc) {
        return filled.value[static_cast<std::size_t>((row + dr) * columns + (column + dc + columns) % columns)];
      };
      const double uu = at(0, -1) - 2.0 * at(0, 0) + at(0, 1);
      const double vv = at(-1, 0) - 2.0 * at(0, 0) + at(1, 0);
      const double uv = 0.25 * (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1));
      steps[static_cast<std::size_t>(row * columns + column)] = {
          square_if_step(uu, std::sqrt(6.0)), square_if_step(vv, std::sqrt(6.0)), square_if_step(uv, 0.5)};
    }
  }
  return steps;
}

RoughnessWeights LocalWeights(const CellGrid& cells, const SplineSurface& pilot, double noise_sigma) {
  const FilledCells filled = Fill(cells, pilot, noise_sigma);
  const std::vector<CellBend> squares = SquaredBends(cells, filled);
  const std::vector<CellBend> steps = SquaredSteps(cells, filled, noise_sigma);
  const auto component = [&](double CellBend::*member) {
    std::vector<double> values(squares.size());
    for (std::size_t k = 0; k < squares.size(); ++k) values[k] = squares[k].*member;
    return values;
  };
  // Windows are longer across the direction of the difference: creases run that way.
  const std::vector<double> uu = WindowMean(cells, component(&CellBend::uu), 3, 2);
  const std::vector<double> vv = WindowMean(cells, component(&CellBend::vv), 2, 3);
  const std::vector<double> uv = WindowMean(cells, component(&CellBend::uv), 2, 2);
  const auto weight = [](double mean_square, double step_square) {
    return 1.0 / (std::max({0.0, kVarianceInflation * mean_square, step_square}) + kSmallestBend * kSmallestBend);
  };
  RoughnessWeights weights;
  weights.cells.resize(squares.size());
  for (std::size_t k = 0; k < squares.size(); ++k)
    weights.cells[k] = {weight(uu[k], steps[k].uu), weight(vv[k], steps[k].vv), weight(uv[k], steps[k].uv)};
  return weights;
}

}  // namespace annulus
