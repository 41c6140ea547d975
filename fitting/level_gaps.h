#pragma once

#include <cstddef>
#include <vector>

#include "fitting/ring_image.h"

namespace annulus {

/// Neighbouring columns of one row without a return.
struct LevelGap {
  std::size_t row = 0;
  std::size_t before = 0;  ///< Seen column clockwise of the gap.
  std::size_t after = 0;   ///< Seen column counter-clockwise of it.
  double width = 0.0;      ///< rad, from `before` to `after`.
  double chord = 0.0;      ///< mm, between the two returns.
  double fall = 0.0;       ///< Smaller of the two slopes with which the radius falls towards the gap, mm/mm.
  bool open = false;       ///< Air: its ends are silhouettes. Else something that gives no return.
};

/// Finds the gaps of all rows and tells air from what gives no return, by following them over the heights: where legs
/// stand apart, rays pass between them, and both ends fall off towards the axis steeply as a round limb does at its
/// silhouette. Row by row upward, in a row by column.
[[nodiscard]] std::vector<LevelGap> FindLevelGaps(const RingImage& image);

/// Whether two gaps have a direction in common.
[[nodiscard]] bool Overlap(const RingImage& image, const LevelGap& a, const LevelGap& b);

}  // namespace annulus
