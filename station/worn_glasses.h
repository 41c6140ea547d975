#pragma once

#include <string>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/placement.h"

namespace annulus {

/// A frame put on the head of a surface: face points found, frame placed, face cleared. Fails if there is no head, or
/// if the frame cannot be worn on it.
[[nodiscard]] Result<WornFrame> FitFrame(const SplineSurface& head, const FrameDesign& design);

/// The solid of a worn frame as an STL file, frame frame, without lenses.
[[nodiscard]] Result<std::string> FrameStl(const WornFrame& worn);

}  // namespace annulus
