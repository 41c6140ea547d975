#pragma once

#include <vector>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// What closed, outward-oriented meshes hold in common, mm³: the sum of their volumes less the volume of their union.
/// Measured along lines parallel to y that stand on a square grid of `pitch` mm; the error falls with the pitch and
/// does not touch what belongs to one mesh only. A place within n meshes counts n - 1 times. Requires pitch > 0.
[[nodiscard]] double OverlapVolume(const std::vector<TriangleMesh>& meshes, double pitch);

}  // namespace annulus
