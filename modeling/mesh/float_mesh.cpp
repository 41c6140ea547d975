#include "modeling/mesh/float_mesh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <vector>

namespace annulus {
namespace {

using Corner = std::array<float, 3>;
using Face = std::array<std::uint32_t, 3>;

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

/// The same triangle, with its smallest index first.
Face Turned(Face face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

/// Takes out as many copies of each triangle as there are of its reverse.
std::vector<Face> WithoutBackToBack(const std::vector<Face>& faces) {
  std::map<Face, int> count;
  for (const Face& face : faces) ++count[Turned(face)];
  std::vector<Face> left;
  for (const Face& face : faces) {
    const auto reverse = count.find(Turned({face[0], face[2], face[1]}));
    if (reverse != count.end() && reverse->second > 0) {
      --reverse->second;
      continue;
    }
    left.push_back(face);
  }
  return left;
}

}  // namespace

TriangleMesh InFloats(const TriangleMesh& mesh) {
  std::map<Corner, std::uint32_t> place;
  std::vector<std::uint32_t> welded;
  std::vector<Corner> corners;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    // + 0 makes -0 and 0 the same place.
    const Corner corner{static_cast<float>(v.x()) + 0.0F, static_cast<float>(v.y()) + 0.0F,
                        static_cast<float>(v.z()) + 0.0F};
    const auto [at, is_new] = place.emplace(corner, static_cast<std::uint32_t>(corners.size()));
    if (is_new) corners.push_back(corner);
    welded.push_back(at->second);
  }
  std::vector<Face> faces;
  for (const Face& face : mesh.faces) {
    const Face f{welded[face[0]], welded[face[1]], welded[face[2]]};
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) faces.push_back(f);
  }
  TriangleMesh rounded;
  std::vector<std::uint32_t> index(corners.size(), kUnused);
  for (const Face& face : WithoutBackToBack(faces)) {
    Face out{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& at = index[face[k]];
      if (at == kUnused) {
        at = static_cast<std::uint32_t>(rounded.vertices.size());
        const Corner& c = corners[face[k]];
        rounded.vertices.emplace_back(c[0], c[1], c[2]);
      }
      out[k] = at;
    }
    rounded.faces.push_back(out);
  }
  return rounded;
}

}  // namespace annulus
