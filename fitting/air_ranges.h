#pragma once

#include <cstddef>
#include <vector>

#include "fitting/level_gaps.h"
#include "fitting/ring_image.h"
#include "fitting/section_topology.h"

namespace annulus {

/// A run of columns, from one counter-clockwise to the other, both included.
struct ColumnArc {
  std::size_t from = 0;
  std::size_t to = 0;
};

/// Whether two runs have a column in common.
[[nodiscard]] bool Overlap(const RingImage& image, const ColumnArc& a, const ColumnArc& b);

/// The gaps through which air was seen, row by row.
class OpenGaps {
 public:
  /// Keeps the open ones of `gaps`, which are in the order of the rows.
  OpenGaps(const RingImage& image, const std::vector<LevelGap>& gaps);

  [[nodiscard]] std::size_t Count(std::size_t row) const { return first_of_row_[row + 1] - first_of_row_[row]; }
  /// The runs of columns between the gaps of a row; none without a gap.
  [[nodiscard]] std::vector<ColumnArc> Arcs(std::size_t row) const;

 private:
  std::vector<LevelGap> open_;
  std::vector<std::size_t> first_of_row_;
};

/// Consecutive rows, both included, that are seen alike.
struct AirRange {
  std::size_t first = 0;
  std::size_t last = 0;
  LevelView view = LevelView::kOneLoop;
};

/// What each row is by its own gaps: empty, one loop, the axis outside (one opening), or several loops.
[[nodiscard]] std::vector<LevelView> ViewsOfRows(const RingImage& image, const OpenGaps& gaps);

/// Ranges of rows with air at the axis, upward: several loops if at least three rows show that, else the axis outside.
/// Interruptions of 20 mm are closed, between several loops of 100 mm (knees that touch); ranges of less than 20 mm or
/// three rows are dropped.
[[nodiscard]] std::vector<AirRange> FindAirRanges(const RingImage& image, const std::vector<LevelView>& views);

}  // namespace annulus
