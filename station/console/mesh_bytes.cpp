#include "station/console/mesh_bytes.h"

#include <bit>
#include <cstddef>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::uint32_t kMagic = 0x4d534e41;  // "ANSM"
constexpr std::uint32_t kVersion = 1;

void Put(std::string& bytes, std::uint32_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>((value >> shift) & 0xffU));
}

void Put(std::string& bytes, float value) { Put(bytes, std::bit_cast<std::uint32_t>(value)); }

void Put(std::string& bytes, const Eigen::Vector3d& vector) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) Put(bytes, static_cast<float>(vector[axis]));
}

/// 0 measured, 1 inferred, 2 unknown: the page colours what is worse by what is greater.
char KnowledgeByte(Knowledge knowledge) { return static_cast<char>(2 - static_cast<int>(knowledge)); }

}  // namespace

std::string MeshBytes(const std::vector<MeshPart>& parts) {
  std::size_t vertices = 0;
  std::size_t faces = 0;
  for (const MeshPart& part : parts) {
    ENSURE(part.knowledge.empty() || part.knowledge.size() == part.mesh.vertices.size(),
           "knowledge of every vertex or of none");
    ENSURE(part.normals.empty() || part.normals.size() == part.mesh.vertices.size(),
           "normals of every vertex or of none");
    vertices += part.mesh.vertices.size();
    faces += part.mesh.faces.size();
  }
  ENSURE(vertices < UINT32_MAX && faces < UINT32_MAX / 3, "a mesh fits into 32-bit indices");
  std::string bytes;
  bytes.reserve(24 + vertices * 25 + faces * 12 + parts.size() * 28);
  Put(bytes, kMagic);
  Put(bytes, kVersion);
  Put(bytes, static_cast<std::uint32_t>(vertices));
  Put(bytes, static_cast<std::uint32_t>(faces));
  for (const MeshPart& part : parts) {
    for (const Eigen::Vector3d& vertex : part.mesh.vertices) Put(bytes, vertex);
  }
  for (const MeshPart& part : parts) {
    for (const Eigen::Vector3d& normal : part.normals.empty() ? VertexNormals(part.mesh) : part.normals) {
      Put(bytes, normal);
    }
  }
  for (const MeshPart& part : parts) {
    if (part.knowledge.empty()) bytes.append(part.mesh.vertices.size(), KnowledgeByte(Knowledge::kMeasured));
    for (const Knowledge knowledge : part.knowledge) bytes.push_back(KnowledgeByte(knowledge));
  }
  bytes.append((4 - vertices % 4) % 4, '\0');
  std::uint32_t first_vertex = 0;
  for (const MeshPart& part : parts) {
    for (const auto& face : part.mesh.faces) {
      for (const std::uint32_t corner : face) {
        ENSURE(corner < part.mesh.vertices.size(), "a face's corners are vertices of its part");
        Put(bytes, first_vertex + corner);
      }
    }
    first_vertex += static_cast<std::uint32_t>(part.mesh.vertices.size());
  }
  Put(bytes, static_cast<std::uint32_t>(parts.size()));
  std::uint32_t first_index = 0;
  for (const MeshPart& part : parts) {
    const auto count = static_cast<std::uint32_t>(3 * part.mesh.faces.size());
    Put(bytes, first_index);
    Put(bytes, count);
    Put(bytes, static_cast<std::uint32_t>(part.kind));
    for (const float channel : part.colour) Put(bytes, channel);
    first_index += count;
  }
  return bytes;
}

}  // namespace annulus
