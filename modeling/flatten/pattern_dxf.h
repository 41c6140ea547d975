#pragma once

#include <string>
#include <vector>

#include "modeling/flatten/pattern_drawing.h"

namespace annulus {

/// The pieces as DXF R12 (AC1009), ASCII, mm, y upwards: POLYLINE on the layers CUT and SEW, LINE on GRAIN and NOTCH,
/// TEXT on LABEL. Coordinates to 1e-4 mm; letters outside ASCII become '?'. Same pieces, same bytes.
[[nodiscard]] std::string PatternDxf(const std::vector<DrawnPiece>& pieces);

}  // namespace annulus
