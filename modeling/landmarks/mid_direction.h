#pragma once

#include "modeling/measure/measured_surface.h"

namespace annulus {

/// The direction, rad, of the point at height z (mm) of the subject's mid-plane towards `toward` (rad: the front, or
/// the front plus pi for the back). The mid-plane passes through the section's centroid.
[[nodiscard]] double MidDirection(const MeasuredSurface& body, double toward, double z);

}  // namespace annulus
