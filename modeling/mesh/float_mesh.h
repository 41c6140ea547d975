#pragma once

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// The mesh as a file of float32 coordinates holds it: vertices rounded to float32, those at the same place made one,
/// triangles that have lost a side left out, and so are pairs of triangles back to back. A closed mesh stays closed.
/// Vertices without a triangle are left out.
[[nodiscard]] TriangleMesh InFloats(const TriangleMesh& mesh);

}  // namespace annulus
