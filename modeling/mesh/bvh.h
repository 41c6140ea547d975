#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// Where a ray first meets a mesh.
struct MeshHit {
  double distance_mm = 0.0;  ///< Along the ray from its origin, mm.
  std::uint32_t face = 0;    ///< Index into the mesh's faces; the smallest of those at the same distance.
  Eigen::Vector3d normal;    ///< Unit normal of the face, outward for an outward-oriented mesh.
};

/// A bounding volume hierarchy over a copy of a mesh's triangles: nearest-hit ray casting in O(log n). The answer does
/// not depend on the order of traversal. Immutable; reentrant. Triangles without area are never hit.
class Bvh {
 public:
  /// Requires face indices within the vertices.
  explicit Bvh(const TriangleMesh& mesh);

  /// The nearest triangle, from either side, with 0 <= distance <= max_distance_mm; the closed form of Möller and
  /// Trumbore (1997). Edges count as hit, with a margin of 1e-12 of the triangle, so that closed meshes leak nowhere.
  [[nodiscard]] std::optional<MeshHit> Cast(const Ray& ray, double max_distance_mm) const;

 private:
  struct Triangle {
    Eigen::Vector3d corner, edge1, edge2;
    std::uint32_t face;
  };
  struct Node {
    Eigen::Vector3d low, high;
    std::uint32_t first = 0;  // leaf: first triangle; inner: right child (the left one is the next node)
    std::uint32_t count = 0;  // leaf: triangles; inner: 0
  };

  std::uint32_t Build(std::uint32_t first, std::uint32_t count);
  static std::optional<MeshHit> CastTriangle(const Triangle& triangle, const Ray& ray, double max_distance_mm);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace annulus
