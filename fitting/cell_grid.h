#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sample_grid.h"
#include "fitting/sample_screening.h"
#include "fitting/spline_surface.h"
#include "fitting/surface_model.h"

namespace annulus {

/// A regular grid over (theta, z) with about one sample per cell: where the penalty is evaluated, local roughness is
/// estimated and knowledge is told. Cell (column, row) is centred on theta = column·theta_step, z = z_min + row·z_step.
class CellGrid {
 public:
  /// Spans the heights of the good samples with as many columns as the ring has sensors and rows at the scan's pitch.
  /// Requires at least two distinct heights.
  CellGrid(std::span<const SurfaceSample> samples, const SampleGrid& order, std::span<const SampleVerdict> verdicts);

  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] double theta_step() const { return theta_step_; }  ///< rad
  [[nodiscard]] double z_step() const { return z_step_; }          ///< mm
  [[nodiscard]] double z_min() const { return z_min_; }            ///< mm, lowest good sample
  [[nodiscard]] double z_max() const { return z_max_; }            ///< mm, highest good sample
  [[nodiscard]] double theta(std::size_t column) const { return static_cast<double>(column) * theta_step_; }
  [[nodiscard]] double z(std::size_t row) const { return z_min_ + static_cast<double>(row) * z_step_; }
  /// Number of good samples in a cell.
  [[nodiscard]] std::uint32_t count(std::size_t column, std::size_t row) const { return count_[Index(column, row)]; }
  /// Their mean radius, mm; 0 in an empty cell.
  [[nodiscard]] double mean(std::size_t column, std::size_t row) const { return mean_[Index(column, row)]; }
  [[nodiscard]] std::size_t Index(std::size_t column, std::size_t row) const { return row * columns_ + column; }
  /// The cell that holds a sample.
  [[nodiscard]] std::size_t IndexOf(const SurfaceSample& sample) const;

 private:
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  double theta_step_ = 0.0;
  double z_step_ = 0.0;
  double z_min_ = 0.0;
  double z_max_ = 0.0;
  std::vector<std::uint32_t> count_;
  std::vector<double> mean_;
};

/// How far from the nearest good sample the surface still counts as inferred, mm along the surface.
inline constexpr double kInferenceReach = 40.0;

/// What is measured (a good sample in the cell or beside it), inferred (within kInferenceReach of one) and unknown.
[[nodiscard]] KnowledgeMap BuildKnowledge(const CellGrid& cells, const SplineSurface& surface);

}  // namespace annulus
