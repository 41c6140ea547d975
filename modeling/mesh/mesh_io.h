#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "base/result.h"
#include "base/storage.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// Reads a mesh by its extension: .obj, .ply (ascii, binary little or big endian) or .stl (ascii or binary, told apart
/// by content; corners at the same place welded). Units are taken as they are. Polygons become fans of triangles;
/// normals, colours, textures and lines are skipped. Fails on anything else, with the line number where the file is
/// text: unknown format, coordinates that are not finite or over 1e9, indices outside the vertices, counts that the
/// file's size cannot hold, no triangle at all.
Result<TriangleMesh> ReadMesh(Storage& storage, const std::string& path);

enum class MeshFormat { kObj, kPly, kStl };

/// The same from memory; `what` names it in messages.
Result<TriangleMesh> ParseMesh(std::span<const std::byte> bytes, MeshFormat format, const std::string& what);

/// Binary STL: 80 bytes of `title` padded by blanks (must not start with "solid"; it is cut to fit), float32 corners
/// and unit normals. No date: same mesh, same bytes.
[[nodiscard]] std::string WriteStl(const TriangleMesh& mesh, const std::string& title);

/// Binary little-endian PLY with float64 coordinates.
[[nodiscard]] std::string WritePly(const TriangleMesh& mesh);

/// Wavefront OBJ with coordinates to 1e-6 mm.
[[nodiscard]] std::string WriteObj(const TriangleMesh& mesh);

}  // namespace annulus
