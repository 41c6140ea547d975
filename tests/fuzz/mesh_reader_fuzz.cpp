/// The mesh readers: the first byte chooses the format, the rest is the file. Beyond "no crash": what is accepted has
/// triangles, indices within its vertices and finite coordinates, can be cut and cast at, and survives being written as
/// PLY and read again.
#include <cmath>
#include <cstdint>

#include "base/ensure.h"
#include "modeling/mesh/bvh.h"
#include "modeling/mesh/mesh_io.h"
#include "modeling/mesh/mesh_section.h"

namespace {

using namespace annulus;

void CheckAccepted(const TriangleMesh& mesh) {
  ENSURE(!mesh.faces.empty(), "an accepted mesh has triangles");
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t vertex : face) ENSURE(vertex < mesh.vertices.size(), "indices are within the vertices");
  }
  for (const Eigen::Vector3d& vertex : mesh.vertices) ENSURE(vertex.allFinite(), "coordinates are finite");
  const std::string bytes = WritePly(mesh);
  const Result<TriangleMesh> again =
      ParseMesh(std::as_bytes(std::span(bytes.data(), bytes.size())), MeshFormat::kPly, "again");
  ENSURE(again.has_value(), "what we write can be read");
  ENSURE(again->vertices == mesh.vertices && again->faces == mesh.faces, "reading returns what was written");
  for (const SectionLoop& loop : SliceMesh(mesh, mesh.vertices.front().z())) {
    ENSURE(std::isfinite(loop.perimeter_mm) && std::isfinite(loop.area_mm2), "measures are finite");
  }
  const auto hit = Bvh(mesh).Cast({{0.1, 0.2, 100.0}, {0.0, 0.0, -1.0}}, 1e6);
  ENSURE(!hit || (hit->distance_mm >= 0.0 && hit->face < mesh.faces.size()), "a hit is on a triangle");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  constexpr MeshFormat kFormats[] = {MeshFormat::kObj, MeshFormat::kPly, MeshFormat::kStl};
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  const Result<TriangleMesh> mesh = ParseMesh(bytes, kFormats[data[0] % 3], "fuzz");
  if (mesh) {
    CheckAccepted(*mesh);
  } else {
    ENSURE(mesh.error().Text().find('\n') == std::string::npos, "an error is one line");
  }
  return 0;
}
