#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sample_grid.h"

namespace annulus {

/// The radii of a scan as an image: rows are levels (upward), columns are sensors (cyclic), NaN where no return came or
/// a return stands alone. Cheap: no screening is needed to see what hangs together.
class RingImage {
 public:
  RingImage(std::span<const SurfaceSample> samples, const SampleGrid& grid);

  [[nodiscard]] std::size_t rows() const { return grid_->rows(); }
  [[nodiscard]] std::size_t columns() const { return grid_->columns(); }
  [[nodiscard]] std::size_t cells() const { return radius_.size(); }
  [[nodiscard]] double z(std::size_t row) const { return grid_->row_z(row); }                   ///< mm
  [[nodiscard]] double theta(std::size_t column) const { return grid_->column_theta(column); }  ///< rad
  [[nodiscard]] std::size_t Index(std::size_t row, std::size_t column) const { return row * columns() + column; }
  /// mm; NaN: nothing, or a return that no neighbour agrees with.
  [[nodiscard]] double Radius(std::size_t row, std::size_t column) const { return radius_[Index(row, column)]; }
  [[nodiscard]] bool IsSeen(std::size_t row, std::size_t column) const { return !std::isnan(Radius(row, column)); }
  /// mm; NaN only where there is nothing.
  [[nodiscard]] double RawRadius(std::size_t row, std::size_t column) const { return raw_[Index(row, column)]; }
  /// Columns of a row with a return that is not alone, ascending.
  [[nodiscard]] std::vector<std::size_t> SeenColumns(std::size_t row) const;
  /// Angle from one column to another, counter-clockwise, rad, [0, 2 pi).
  [[nodiscard]] double AngleFrom(std::size_t from, std::size_t to) const;

  [[nodiscard]] const SampleGrid& grid() const { return *grid_; }

 private:
  const SampleGrid* grid_;  ///< Borrowed; outlives this.
  std::vector<double> raw_;
  std::vector<double> radius_;
};

}  // namespace annulus
