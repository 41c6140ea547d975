#pragma once

#include <vector>

#include "base/result.h"
#include "render/image.h"
#include "station/inside_glasses.h"

namespace annulus {

/// What both lenses give in every direction of gaze, as the wearer sees it: the left eye's map at the left, the
/// wearer's left is left, up is up. Rows: error of the mean power and astigmatic error (D, contours at 0.12, 0.25, 0.5
/// and 1), magnification (%), thickness along the line of sight (mm). Axes are degrees of gaze from straight ahead; the
/// end of the lens, what frame and nose pads hide, and what lies beside the lens are drawn; `marked` directions have a
/// ring. One column if only one eye is asked for. Requires at least one eye.
[[nodiscard]] Result<RgbImage> DrawInsideMap(const InsideGlasses& glasses, const std::vector<Eye>& eyes,
                                             const std::vector<Gaze>& marked);

}  // namespace annulus
