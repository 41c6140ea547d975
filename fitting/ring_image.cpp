#include "fitting/ring_image.h"

#include "base/frames.h"

namespace annulus {

RingImage::RingImage(std::span<const SurfaceSample> samples, const SampleGrid& grid) : grid_(&grid) {
  constexpr double kAgree = 15.0;  // mm; neighbours on skin are closer than this, save at edges
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const std::size_t rows = grid.rows();
  const std::size_t columns = grid.columns();
  raw_.resize(rows * columns);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t k = grid.At(row, column);
      raw_[row * columns + column] = k == SampleGrid::kNone ? kNothing : samples[k].radius;
    }
  }
  // A finger one sensor wide agrees with what is above and below it, a wild return with hardly anything.
  radius_ = raw_;
  for (std::size_t row = 0; row < rows; ++row) {
    const double* const here = raw_.data() + row * columns;
    for (std::size_t column = 0; column < columns; ++column) {
      const double r = here[column];
      int agree = 0;
      const auto count = [&](double other) { agree += std::abs(other - r) <= kAgree ? 1 : 0; };  // NaN does not agree
      count(here[column == 0 ? columns - 1 : column - 1]);
      count(here[column + 1 == columns ? 0 : column + 1]);
      if (agree == 2) continue;
      if (row > 0) count(here[static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(columns)]);
      if (row + 1 < rows) count(here[column + columns]);
      if (agree < 2) radius_[row * columns + column] = kNothing;
    }
  }
}

std::vector<std::size_t> RingImage::SeenColumns(std::size_t row) const {
  std::vector<std::size_t> seen;
  for (std::size_t column = 0; column < columns(); ++column) {
    if (IsSeen(row, column)) seen.push_back(column);
  }
  return seen;
}

double RingImage::AngleFrom(std::size_t from, std::size_t to) const { return WrapAngle(theta(to) - theta(from)); }

}  // namespace annulus
