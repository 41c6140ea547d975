#pragma once

#include <cstddef>
#include <vector>

#include "fitting/ring_image.h"

namespace annulus {

/// Something that stands before the main surface, such as an arm: cells of the image that hang together.
struct FrontObject {
  double z_min = 0.0;              ///< mm
  double z_max = 0.0;              ///< mm
  std::size_t column_from = 0;     ///< From this column counter-clockwise …
  std::size_t column_to = 0;       ///< … to this one.
  double x = 0.0;                  ///< Mean position, mm.
  double y = 0.0;                  ///< mm
  std::vector<std::size_t> cells;  ///< Of the image, ascending.
  double fingers_z_min = 0.0;      ///< Heights at which it is several arcs beside each other, mm;
  double fingers_z_max = 0.0;      ///< equal to fingers_z_min: nowhere.
  std::size_t fingers = 0;         ///< Most arcs on one level.
  [[nodiscard]] bool HasFingers() const { return fingers > 1; }
};

/// Finds what stands before the main surface: per level, runs of returns with a step of half a wrist (25 mm) or more at
/// both ends and at most a quarter turn wide, that hang together over at least 20 mm of height.
[[nodiscard]] std::vector<FrontObject> FindFrontObjects(const RingImage& image);

}  // namespace annulus
