#pragma once

#include <cstddef>
#include <vector>

#include "fitting/ring_image.h"

namespace annulus {

/// Where the surface folds over: chin, brim, hem.
struct Overhang {
  double z_min = 0.0;  ///< mm
  double z_max = 0.0;  ///< mm
  std::size_t column_from = 0;
  std::size_t column_to = 0;
  std::size_t cells = 0;  ///< Cells at its edge.
  double drop = 0.0;      ///< Largest loss of radius, mm …
  double height = 0.0;    ///< … and the height that it takes there, mm.
};

/// Finds stretches of at least 25 mm along the ring on which the radius falls, within about 5 mm of height downward (a
/// level's pitch, if that is more), by at least 15 mm and three times the height: closer to the horizontal than 20
/// degrees, more than a horizontal ray can see into. Cells in `leave_out` take no part.
[[nodiscard]] std::vector<Overhang> FindOverhangs(const RingImage& image, const std::vector<char>& leave_out);

}  // namespace annulus
