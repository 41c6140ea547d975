#include "fitting/overhangs.h"

#include <algorithm>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kSmallestDrop = 15.0;  // mm
constexpr double kSmallestSlope = 3.0;
constexpr double kHeight = 5.0;       // mm
constexpr double kNarrowest = 25.0;   // mm, along the ring
constexpr double kSameObject = 20.0;  // mm of height between rows of one overhang

/// Neighbouring columns of one row at which the radius falls to the row `below`.
struct Fall {
  std::size_t row = 0;
  std::size_t below = 0;
  std::size_t from = 0;
  std::size_t to = 0;
  std::size_t cells = 0;
  double drop = 0.0;
};

/// mm; NaN where nothing is known or the cell is left out.
double Drop(const RingImage& image, const std::vector<char>& leave_out, std::size_t row, std::size_t below,
            std::size_t column) {
  if (leave_out[image.Index(row, column)] != 0 || leave_out[image.Index(below, column)] != 0) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return image.Radius(row, column) - image.Radius(below, column);
}

void AppendFalls(const RingImage& image, const std::vector<char>& leave_out, std::size_t row, std::size_t below,
                 std::vector<Fall>& falls) {
  const double least = std::max(kSmallestDrop, kSmallestSlope * (image.z(row) - image.z(below)));
  const auto falls_at = [&](std::size_t column) { return Drop(image, leave_out, row, below, column) >= least; };
  const std::size_t n = image.columns();
  std::size_t still = 0;  // a column without a fall, if there is one: a fall may go all around
  while (still + 1 < n && falls_at(still)) ++still;
  const bool all_around = n > 0 && falls_at(still);
  for (std::size_t k = 0; k < (all_around ? 1 : n); ++k) {
    const std::size_t start = image.grid().Column(still, static_cast<std::ptrdiff_t>(k));
    if (!falls_at(start) || (!all_around && falls_at(image.grid().Column(start, -1)))) continue;
    Fall fall{row, below, start, start, 0, 0.0};
    double length = 0.0;
    for (std::size_t column = start; falls_at(column) && fall.cells < n; column = image.grid().Column(column, 1)) {
      length += image.AngleFrom(fall.to, column) * image.Radius(row, column);
      fall.to = column;
      ++fall.cells;
      fall.drop = std::max(fall.drop, Drop(image, leave_out, row, below, column));
    }
    if (length >= kNarrowest) falls.push_back(fall);
  }
}

bool Touch(const RingImage& image, const Overhang& overhang, const Fall& fall) {
  return image.AngleFrom(overhang.column_from, fall.from) <=
             image.AngleFrom(overhang.column_from, overhang.column_to) ||
         image.AngleFrom(fall.from, overhang.column_from) <= image.AngleFrom(fall.from, fall.to);
}

void Join(const RingImage& image, const Fall& fall, std::vector<Overhang>& overhangs) {
  const double low = image.z(fall.below);
  const double high = image.z(fall.row);
  for (Overhang& overhang : overhangs) {
    if (low - overhang.z_max > kSameObject || !Touch(image, overhang, fall)) continue;
    overhang.z_max = std::max(overhang.z_max, high);
    overhang.cells += fall.cells;
    if (fall.drop <= overhang.drop) return;
    overhang.drop = fall.drop;
    overhang.height = high - low;
    overhang.column_from = fall.from;
    overhang.column_to = fall.to;
    return;
  }
  overhangs.push_back({low, high, fall.from, fall.to, fall.cells, fall.drop, high - low});
}

}  // namespace

std::vector<Overhang> FindOverhangs(const RingImage& image, const std::vector<char>& leave_out) {
  std::vector<Fall> falls;
  std::size_t below = 0;
  for (std::size_t row = 1; row < image.rows(); ++row) {
    while (below + 1 < row && image.z(row) - image.z(below + 1) >= kHeight) ++below;
    AppendFalls(image, leave_out, row, below, falls);
  }
  std::vector<Overhang> overhangs;
  for (const Fall& fall : falls) Join(image, fall, overhangs);
  return overhangs;
}

}  // namespace annulus
