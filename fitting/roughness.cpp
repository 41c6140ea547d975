#include "fitting/roughness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr std::size_t kHalf = 2;  // of the 5 × 5 window of the local quadratic
// Prior variance of a second difference over its local mean square, and the least prior sd over the noise's. How much
// is smoothed over all is chosen from the data afterwards.
constexpr double kDataInflation = 16.0;
constexpr double kDataFloor = 0.2;
constexpr double kSurfaceInflation = 4.0;
constexpr double kSurfaceFloor = 0.085;

/// A map over the cells with `margin` columns repeated at both ends of every row, so that windows need no wrapping.
class CellMap {
 public:
  CellMap(const CellGrid& cells, std::size_t margin)
      : columns_(cells.columns()), rows_(cells.rows()), margin_(margin), values_(rows_ * (columns_ + 2 * margin)) {}

  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }
  /// Row r; its column c, −margin … columns + margin − 1, is [c].
  [[nodiscard]] double* Row(std::size_t r) { return values_.data() + r * (columns_ + 2 * margin_) + margin_; }
  [[nodiscard]] const double* Row(std::size_t r) const {
    return values_.data() + r * (columns_ + 2 * margin_) + margin_;
  }
  /// Fills the margins from the columns.
  void Wrap() {
    for (std::size_t r = 0; r < rows_; ++r) {
      double* row = Row(r);
      for (std::size_t m = 1; m <= margin_; ++m) {
        *(row - m) = row[columns_ - m];
        row[columns_ + m - 1] = row[m - 1];
      }
    }
  }

 private:
  std::size_t columns_;
  std::size_t rows_;
  std::size_t margin_;
  std::vector<double> values_;
};

/// Values on the cells: the mean of the samples, or a bridge where there is none.
struct FilledCells {
  CellMap value;
  CellMap noise_variance;  ///< Of `value`, mm²; 0 on bridges.
};

/// A value found on the way and how many cells ago.
struct LastSeen {
  double value = 0.0;
  double distance = std::numeric_limits<double>::infinity();

  void Step() { distance += 1.0; }
};

/// Gathers, for every empty cell, the nearest values before and after it in its row and its column, weighted by the
/// inverse of their distance.
class Bridges {
 public:
  explicit Bridges(const CellGrid& cells) : cells_(cells), sum_(cells, 0), weight_(cells, 0) {
    const std::size_t columns = cells.columns();
    const std::size_t rows = cells.rows();
    for (std::size_t row = 0; row < rows; ++row) {
      // Twice around, because it is a circle.
      Walk({2 * columns, columns}, [&](std::size_t k) { return std::array{k % columns, row}; });
      Walk({2 * columns, columns}, [&](std::size_t k) { return std::array{columns - 1 - k % columns, row}; });
    }
    for (std::size_t column = 0; column < columns; ++column) {
      Walk({rows, 0}, [&](std::size_t k) { return std::array{column, k}; });
      Walk({rows, 0}, [&](std::size_t k) { return std::array{column, rows - 1 - k}; });
    }
  }

  [[nodiscard]] double At(std::size_t column, std::size_t row) const {
    const double weight = weight_.Row(row)[column];
    return weight > 0.0 ? sum_.Row(row)[column] / weight : 0.0;
  }

 private:
  struct Steps {
    std::size_t count = 0;
    std::size_t idle = 0;  ///< The first steps only look.
  };
  template <class Place>
  void Walk(const Steps& steps, Place place) {
    LastSeen seen;
    for (std::size_t k = 0; k < steps.count; ++k) {
      const auto [column, row] = place(k);
      seen.Step();
      if (cells_.count(column, row) > 0) {
        seen = {cells_.mean(column, row), 0.0};
      } else if (k >= steps.idle && std::isfinite(seen.distance)) {
        const double weight = 1.0 / std::max(1.0, seen.distance);
        sum_.Row(row)[column] += weight * seen.value;
        weight_.Row(row)[column] += weight;
      }
    }
  }

  const CellGrid& cells_;
  CellMap sum_;
  CellMap weight_;
};

FilledCells Fill(const CellGrid& cells, double noise_sigma) {
  FilledCells filled{CellMap(cells, kHalf), CellMap(cells, kHalf)};
  const Bridges bridges(cells);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::uint32_t count = cells.count(column, row);
      filled.value.Row(row)[column] = count > 0 ? cells.mean(column, row) : bridges.At(column, row);
      if (count > 0) {
        filled.noise_variance.Row(row)[column] = noise_sigma * noise_sigma / static_cast<double>(count);
      }
    }
  }
  filled.value.Wrap();
  filled.noise_variance.Wrap();
  return filled;
}

/// One map per second difference.
struct BendMaps {
  CellMap uu;
  CellMap vv;
  CellMap uv;
};

/// Squares of the second differences of the local quadratic y ≈ … + ½ uu·x² + uv·x·y + ½ vv·y² over 5 × 5 cells, with
/// the variance that noise gives them taken off.
BendMaps SquaredBends(const CellGrid& cells, const FilledCells& filled) {
  // Least squares: uu = Σ (x² − 2) v / 35, vv = Σ (y² − 2) v / 35, uv = Σ x y v / 100. First sums along rows.
  constexpr std::array<double, 5> kBend{2.0, -1.0, -2.0, -1.0, 2.0};
  constexpr std::array<double, 5> kSlope{-2.0, -1.0, 0.0, 1.0, 2.0};
  std::vector<std::array<double, 6>> sums(cells.columns() * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const double* v = filled.value.Row(row) + column - kHalf;
      const double* n = filled.noise_variance.Row(row) + column - kHalf;
      std::array<double, 6>& sum = sums[cells.Index(column, row)];
      sum.fill(0.0);
      for (std::size_t k = 0; k < 5; ++k) {
        sum[0] += v[k];
        sum[1] += kSlope[k] * v[k];
        sum[2] += kBend[k] * v[k];
        sum[3] += n[k];
        sum[4] += kSlope[k] * kSlope[k] * n[k];
        sum[5] += kBend[k] * kBend[k] * n[k];
      }
    }
  }
  BendMaps squares{CellMap(cells, 3), CellMap(cells, 3), CellMap(cells, 3)};
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const std::size_t centre = std::clamp(row, kHalf, cells.rows() - 1 - kHalf);
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      std::array<double, 6> total{};  // uu, vv, uv and their variances
      for (std::size_t k = 0; k < 5; ++k) {
        const std::array<double, 6>& sum = sums[cells.Index(column, centre + k - kHalf)];
        total[0] += sum[2];
        total[1] += kBend[k] * sum[0];
        total[2] += kSlope[k] * sum[1];
        total[3] += sum[5];
        total[4] += kBend[k] * kBend[k] * sum[3];
        total[5] += kSlope[k] * kSlope[k] * sum[4];
      }
      squares.uu.Row(row)[column] = (total[0] * total[0] - total[3]) / (35.0 * 35.0);
      squares.vv.Row(row)[column] = (total[1] * total[1] - total[4]) / (35.0 * 35.0);
      squares.uv.Row(row)[column] = (total[2] * total[2] - total[5]) / (100.0 * 100.0);
    }
  }
  squares.uu.Wrap();
  squares.vv.Wrap();
  squares.uv.Wrap();
  return squares;
}

/// Mean over a window of (2·half_rows+1) × (2·half_columns+1) cells, cyclic in columns, cut off at the first and last
/// row.
CellMap WindowMean(const CellGrid& cells, const CellMap& values, std::size_t half_rows, std::size_t half_columns) {
  CellMap across(cells, 0);
  const double width = static_cast<double>(2 * half_columns + 1);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const double* v = values.Row(row) + column - half_columns;
      double sum = 0.0;
      for (std::size_t k = 0; k < 2 * half_columns + 1; ++k) sum += v[k];
      across.Row(row)[column] = sum / width;
    }
  }
  CellMap mean(cells, 0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const std::size_t first = row >= half_rows ? row - half_rows : 0;
    const std::size_t last = std::min(cells.rows() - 1, row + half_rows);
    double* to = mean.Row(row);
    for (std::size_t r = first; r <= last; ++r) {
      const double* from = across.Row(r);
      for (std::size_t column = 0; column < cells.columns(); ++column) to[column] += from[column];
    }
    const double share = 1.0 / static_cast<double>(last - first + 1);
    for (std::size_t column = 0; column < cells.columns(); ++column) to[column] *= share;
  }
  return mean;
}

/// Squared second differences between direct neighbours, kept only where they stand out of the noise: steps and edges.
BendMaps SquaredSteps(const CellGrid& cells, const FilledCells& filled, double noise_sigma) {
  constexpr double kStandsOut = 5.0;  // noise standard deviations
  const double straight = 6.0 * kStandsOut * kStandsOut * noise_sigma * noise_sigma;
  const double mixed = 0.25 * kStandsOut * kStandsOut * noise_sigma * noise_sigma;
  const auto square_if_step = [](double difference, double threshold) {
    const double square = difference * difference;
    return square > threshold ? square : 0.0;
  };
  BendMaps steps{CellMap(cells, 0), CellMap(cells, 0), CellMap(cells, 0)};
  for (std::size_t row = 1; row + 1 < cells.rows(); ++row) {
    const double* below = filled.value.Row(row - 1);
    const double* at = filled.value.Row(row);
    const double* above = filled.value.Row(row + 1);
    for (std::size_t c = 0; c < cells.columns(); ++c) {
      const double* left = at + c - 1;
      steps.uu.Row(row)[c] = square_if_step(left[0] - 2.0 * at[c] + at[c + 1], straight);
      steps.vv.Row(row)[c] = square_if_step(below[c] - 2.0 * at[c] + above[c], straight);
      const double uv = 0.25 * (above[c + 1] - *(above + c - 1) - below[c + 1] + *(below + c - 1));
      steps.uv.Row(row)[c] = square_if_step(uv, mixed);
    }
  }
  return steps;
}

/// Prior variance of a second difference: `inflation` times the mean square around, or the step, and a floor.
struct Prior {
  double inflation = 0.0;
  double floor = 0.0;  ///< mm; no cell is taken to be flatter than this
};

RoughnessWeights WeightsOfSquares(const CellGrid& cells, const BendMaps& squares, const BendMaps& steps,
                                  const Prior& prior) {
  // Windows are longer across the direction of the difference: creases run that way.
  const CellMap uu = WindowMean(cells, squares.uu, 3, 2);
  const CellMap vv = WindowMean(cells, squares.vv, 2, 3);
  const CellMap uv = WindowMean(cells, squares.uv, 2, 2);
  const auto weight = [&](double mean_square, double step_square) {
    return 1.0 / (std::max({0.0, prior.inflation * mean_square, step_square}) + prior.floor * prior.floor);
  };
  RoughnessWeights weights;
  weights.cells.resize(cells.columns() * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t c = 0; c < cells.columns(); ++c) {
      weights.cells[cells.Index(c, row)] = {weight(uu.Row(row)[c], steps.uu.Row(row)[c]),
                                            weight(vv.Row(row)[c], steps.vv.Row(row)[c]),
                                            weight(uv.Row(row)[c], steps.uv.Row(row)[c])};
    }
  }
  return weights;
}

}  // namespace

struct RoughnessPrior::Maps {
  const CellGrid& cells;
  double noise_sigma = 0.0;
  FilledCells filled;
  BendMaps steps;
};

RoughnessPrior::RoughnessPrior(const CellGrid& cells, double noise_sigma) {
  FilledCells filled = Fill(cells, noise_sigma);
  BendMaps steps = SquaredSteps(cells, filled, noise_sigma);
  maps_ = std::make_unique<const Maps>(Maps{cells, noise_sigma, std::move(filled), std::move(steps)});
}
RoughnessPrior::RoughnessPrior(RoughnessPrior&&) noexcept = default;
RoughnessPrior& RoughnessPrior::operator=(RoughnessPrior&&) noexcept = default;
RoughnessPrior::~RoughnessPrior() = default;

RoughnessWeights RoughnessPrior::OfData() const {
  return WeightsOfSquares(maps_->cells, SquaredBends(maps_->cells, maps_->filled), maps_->steps,
                          {kDataInflation, kDataFloor * maps_->noise_sigma});
}

RoughnessWeights RoughnessPrior::OfSurface(const std::vector<CellBend>& bends) const {
  const CellGrid& cells = maps_->cells;
  BendMaps squares{CellMap(cells, 3), CellMap(cells, 3), CellMap(cells, 3)};
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t c = 0; c < cells.columns(); ++c) {
      const CellBend& bend = bends[cells.Index(c, row)];
      squares.uu.Row(row)[c] = bend.uu * bend.uu;
      squares.vv.Row(row)[c] = bend.vv * bend.vv;
      squares.uv.Row(row)[c] = bend.uv * bend.uv;
    }
  }
  squares.uu.Wrap();
  squares.vv.Wrap();
  squares.uv.Wrap();
  return WeightsOfSquares(cells, squares, maps_->steps, {kSurfaceInflation, kSurfaceFloor * maps_->noise_sigma});
}

std::vector<char> RoughnessPrior::Edges() const {
  const CellGrid& cells = maps_->cells;
  std::vector<char> edges(cells.columns() * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t c = 0; c < cells.columns(); ++c) {
      edges[cells.Index(c, row)] = maps_->steps.uu.Row(row)[c] > 0.0 || maps_->steps.vv.Row(row)[c] > 0.0 ? 1 : 0;
    }
  }
  return edges;
}

}  // namespace annulus
