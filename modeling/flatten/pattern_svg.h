#pragma once

#include <string>
#include <vector>

#include "modeling/flatten/pattern_drawing.h"

namespace annulus {

/// The pieces as one SVG whose width and height are given in mm: printed without scaling it is at 1:1, and the check
/// square at its foot has sides of 100 mm. Classes cut, sew, grain, notch, label. Same pieces, same bytes.
[[nodiscard]] std::string PatternSvg(const std::vector<DrawnPiece>& pieces, const std::string& title);

}  // namespace annulus
