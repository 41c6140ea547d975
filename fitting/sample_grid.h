#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/surface_sample.h"

namespace annulus {

/// Whether a sample can be a point on a body in a ring: finite, radius above 0 and at most 10 m, within 100 m of the
/// floor, angle within 1000 rad, weight from 1e-6 to 1e6.
[[nodiscard]] bool IsUsable(const SurfaceSample& sample);

/// The samples of a scan in the order of the ring: one row per level (all sweeps merged, sorted by height), one column
/// per sensor (sorted by angle, cyclic). Tells each sample who its neighbours on the body are.
/// Stores indices only (4 bytes per cell); the samples must outlive it.
class SampleGrid {
 public:
  /// Marks an empty cell.
  static constexpr std::size_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// Groups the usable `samples` by (sweep, level) and by sensor. A second sample of the same sweep, level and sensor
  /// opens a row of its own, up to the 16th; later ones are not held. If that is most of them, or if samples are so
  /// scattered that they would fill less than one cell in a hundred, they are no scan: the grid is then empty. Requires
  /// fewer than 2^32 - 1 samples.
  explicit SampleGrid(std::span<const SurfaceSample> samples);

  [[nodiscard]] std::size_t rows() const { return row_z_.size(); }
  [[nodiscard]] std::size_t columns() const { return column_theta_.size(); }
  /// Mean height of a row, mm; rows ascend.
  [[nodiscard]] double row_z(std::size_t row) const { return row_z_[row]; }
  /// Angle of a column, rad; columns ascend.
  [[nodiscard]] double column_theta(std::size_t column) const { return column_theta_[column]; }
  /// Index of the sample in a cell, or kNone.
  [[nodiscard]] std::size_t At(std::size_t row, std::size_t column) const { return cells_[row * columns() + column]; }
  /// The column `offset` to the side, cyclic.
  [[nodiscard]] std::size_t Column(std::size_t column, std::ptrdiff_t offset) const {
    const auto n = static_cast<std::ptrdiff_t>(columns());
    return static_cast<std::size_t>(((static_cast<std::ptrdiff_t>(column) + offset) % n + n) % n);
  }
  /// How many directions the ring looks in: the columns, and those that are missing where two neighbours stand two or
  /// more usual gaps apart (sensors without any return).
  [[nodiscard]] std::size_t RingSize() const;

 private:
  std::vector<double> row_z_;
  std::vector<double> column_theta_;
  std::vector<std::uint32_t> cells_;
};

}  // namespace annulus
