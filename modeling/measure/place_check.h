#pragma once

#include <string>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// Radius below which a place is on the ring's axis: there theta has no meaning, mm.
inline constexpr double kAxisRadius = 0.01;

/// "theta = 90 deg, z = 1380 mm".
[[nodiscard]] std::string PlaceText(const SurfacePlace& place);

/// Fails unless the place is finite, within the scanned range, seen, and off the ring's axis; says which.
Status CheckPlace(const MeasuredSurface& body, const SurfacePlace& place, const std::string& attempted);

}  // namespace annulus
