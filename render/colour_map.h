#pragma once

#include "render/colour.h"

namespace annulus {

enum class ColourMap {
  kDiverging,   ///< Blue – white – red for signed values; equal lightness at equal distance from the middle.
  kSequential,  ///< Dark violet – green – light yellow; lightness rises evenly.
};

/// The colour at `share` in [0, 1] (clamped; nan gives kNoDataColour). Built in CIE L*C*h(ab) under D65.
[[nodiscard]] LinearRgb MapColour(ColourMap map, double share);

/// Grey of cells without a value.
inline const LinearRgb kNoDataColour = LinearRgb(0.45F, 0.45F, 0.45F);

}  // namespace annulus
