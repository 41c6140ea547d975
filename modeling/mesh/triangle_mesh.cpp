#include "modeling/mesh/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace annulus {

void Append(TriangleMesh& whole, const TriangleMesh& part) {
  const auto offset = static_cast<std::uint32_t>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
  whole.faces.reserve(whole.faces.size() + part.faces.size());
  for (const auto& face : part.faces) whole.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
}

double SignedVolume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  const Eigen::Vector3d origin = mesh.vertices.front();  // near the mesh, so that little cancels
  double six_volumes = 0.0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]] - origin;
    const Eigen::Vector3d b = mesh.vertices[face[1]] - origin;
    const Eigen::Vector3d c = mesh.vertices[face[2]] - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0;
}

double SurfaceArea(const TriangleMesh& mesh) {
  double two_areas = 0.0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    two_areas += (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).norm();
  }
  return two_areas / 2.0;
}

std::size_t CountOpenEdges(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(mesh.faces.size() * 3);
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(face[k], face[(k + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (const auto& [from, to] : edges) {
    const std::pair<std::uint32_t, std::uint32_t> opposite{to, from};
    const auto [first, last] = std::equal_range(edges.begin(), edges.end(), opposite);
    const auto [mine, mine_end] = std::equal_range(edges.begin(), edges.end(), std::pair{from, to});
    if (last - first != mine_end - mine) ++open;
  }
  return open;
}

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const Eigen::Vector3d twice_area = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    for (const std::uint32_t vertex : face) normals[vertex] += twice_area;
  }
  for (Eigen::Vector3d& normal : normals) {
    const double length = normal.norm();
    normal = length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitZ();
  }
  return normals;
}

}  // namespace annulus
