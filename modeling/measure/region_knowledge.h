#pragma once

#include <span>

#include "modeling/measure/surface_path.h"

namespace annulus {

/// How much of a region of the surface was seen: shares of its skin area. `boundary`: a closed polygon in theta (rad,
/// not wrapped) and z (mm), its last point joined to the first. Along four lines in every row of the knowledge map; a
/// cell that the boundary touches is counted with at least 1e-6.
[[nodiscard]] PathKnowledge KnowledgeWithin(const MeasuredSurface& body, std::span<const SurfacePlace> boundary);

}  // namespace annulus
