#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace annulus {

/// Triangles over shared vertices, mm. Counter-clockwise seen from outside. A plain value: nothing is checked here.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;            ///< mm.
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< Indices into `vertices`.
};

/// Appends `part` to `whole` (no welding).
void Append(TriangleMesh& whole, const TriangleMesh& part);

/// Signed volume by the divergence theorem, mm^3; positive for a closed mesh oriented outward.
[[nodiscard]] double SignedVolume(const TriangleMesh& mesh);

/// Total area of the triangles, mm^2.
[[nodiscard]] double SurfaceArea(const TriangleMesh& mesh);

/// Number of directed edges without their opposite; 0 for a closed, consistently oriented mesh.
[[nodiscard]] std::size_t CountOpenEdges(const TriangleMesh& mesh);

/// Area-weighted unit normals per vertex; (0, 0, 1) where the triangles around have no area.
[[nodiscard]] std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh);

}  // namespace annulus
