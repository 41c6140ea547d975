#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sample_grid.h"
#include "fitting/sample_screening.h"

namespace annulus {

/// The good samples of a scan as a table: one row per height, one column per sensor. Rows of several sweeps that lie
/// closer than a fifth of a sweep's pitch are one row, their radii averaged.
struct RingTable {
  std::vector<double> theta;  ///< rad, ascending.
  std::vector<double> z;      ///< mm, ascending.
  Eigen::MatrixXd radius;     ///< mm, rows × columns; 0 in holes.
  Eigen::MatrixXd weight;     ///< 0 in holes.
};

[[nodiscard]] RingTable BuildRingTable(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                                       std::span<const SampleVerdict> verdicts);

/// Rows that the ring saw all around: without a gap of `widest_gap`, rad, or more.
[[nodiscard]] std::vector<char> CompleteRows(const RingTable& table, double widest_gap);

/// A range of rows, `end` excluded.
struct RowRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// The longest range that begins and ends with a complete row and nowhere has more than `most_missing` incomplete rows
/// in sequence. Empty if no row is complete.
[[nodiscard]] RowRange LongestRange(const std::vector<char>& complete, std::size_t most_missing);

}  // namespace annulus
