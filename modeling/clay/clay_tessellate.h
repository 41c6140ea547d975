#pragma once

#include <cstddef>

#include "modeling/clay/clay_mesh.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// The skin as triangles, `steps` × `steps` cells of two for each leaf, closed: leaves share the vertices on their
/// edges, and a cell next to two finer leaves has theirs, too. Vertices on the surface. Requires steps >= 1.
[[nodiscard]] TriangleMesh Tessellate(const ClayMesh& mesh, std::size_t steps);

}  // namespace annulus
