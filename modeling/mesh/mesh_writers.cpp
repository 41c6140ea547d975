#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "modeling/mesh/mesh_io.h"

namespace annulus {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary writers copy numbers as they lie in memory");

template <class T>
void AppendBytes(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

void AppendFloats(std::string& bytes, const Eigen::Vector3d& v) {
  for (int axis = 0; axis < 3; ++axis) AppendBytes(bytes, static_cast<float>(v[axis]));
}

}  // namespace

std::string WriteStl(const TriangleMesh& mesh, const std::string& title) {
  constexpr std::size_t kTitleSize = 80;
  std::string bytes = title.substr(0, kTitleSize);
  if (bytes.rfind("solid", 0) == 0) bytes[0] = 'S';  // readers take "solid" for the text form
  bytes.resize(kTitleSize, ' ');
  bytes.reserve(kTitleSize + 4 + 50 * mesh.faces.size());
  AppendBytes(bytes, static_cast<std::uint32_t>(mesh.faces.size()));
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const Eigen::Vector3d twice_area = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    const double length = twice_area.norm();
    AppendFloats(bytes, length > 0.0 ? Eigen::Vector3d(twice_area / length) : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    for (const std::uint32_t vertex : face) AppendFloats(bytes, mesh.vertices[vertex]);
    AppendBytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string WritePly(const TriangleMesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment unit mm\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.faces.size());
  bytes.reserve(bytes.size() + 24 * mesh.vertices.size() + 13 * mesh.faces.size());
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) AppendBytes(bytes, v[axis]);
  }
  for (const auto& face : mesh.faces) {
    AppendBytes(bytes, std::uint8_t{3});
    for (const std::uint32_t vertex : face) AppendBytes(bytes, vertex);
  }
  return bytes;
}

std::string WriteObj(const TriangleMesh& mesh) {
  std::string text = "# unit mm\n";
  const auto out = std::back_inserter(text);
  for (const Eigen::Vector3d& v : mesh.vertices) fmt::format_to(out, "v {:.6f} {:.6f} {:.6f}\n", v.x(), v.y(), v.z());
  for (const auto& face : mesh.faces) fmt::format_to(out, "f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
  return text;
}

}  // namespace annulus
