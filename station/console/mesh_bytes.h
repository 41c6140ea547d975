#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "fitting/surface_model.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// What a part of a mesh is, as the page is told.
enum class MeshKind : std::uint32_t { kBody = 0, kFrame = 1, kLens = 2, kHair = 3 };

/// One part of what the page draws.
struct MeshPart {
  MeshKind kind = MeshKind::kBody;
  TriangleMesh mesh;                        ///< Station frame, mm.
  std::vector<Eigen::Vector3d> normals;     ///< Unit, one per vertex, or empty: VertexNormals of the part.
  std::vector<Knowledge> knowledge;         ///< One per vertex, or empty: measured.
  std::array<float, 4> colour{1, 1, 1, 1};  ///< Linear sRGB and opacity, each 0 … 1.
};

/// Parts in the binary form of docs/console_api.md §7 ("Mesh"): little-endian, positions and normals as float32 with
/// normals of each part alone, so that edges between parts stay sharp. Requires fewer than 2^32 vertices and faces,
/// indices within each part, and knowledge and normals of each vertex or of none.
[[nodiscard]] std::string MeshBytes(const std::vector<MeshPart>& parts);

/// What the media type of these bytes is.
inline constexpr const char* kMeshType = "application/octet-stream";

}  // namespace annulus
