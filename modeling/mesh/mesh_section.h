#pragma once

#include <Eigen/Core>
#include <vector>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// One chain of a horizontal section of a mesh.
struct SectionLoop {
  std::vector<Eigen::Vector2d> points;  ///< (x, y), mm; a closed loop does not repeat its first point.
  bool closed = false;                  ///< False where the mesh has a hole.
  double perimeter_mm = 0.0;            ///< Length, with the closing edge if closed.
  double area_mm2 = 0.0;                ///< Signed: positive around material (counter-clockwise); 0 if open.
};

/// The section of a mesh with the plane z = const, loops by falling |area|. Vertices exactly on the plane count as
/// above it, so that each loop closes. Works on meshes that are oriented outward; elsewhere signs may differ.
[[nodiscard]] std::vector<SectionLoop> SliceMesh(const TriangleMesh& mesh, double z);

/// Volume of a closed mesh between two heights (z0 < z1), mm³, exact for its flat triangles: each triangle's part
/// within the slab is integrated (divergence theorem with the field (x, 0, 0), which needs no caps).
[[nodiscard]] double SlabVolume(const TriangleMesh& mesh, double z0, double z1);

}  // namespace annulus
