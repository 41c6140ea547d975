#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "modeling/mesh/bvh.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// The nearest point of a triangle to `p`.
[[nodiscard]] Eigen::Vector3d NearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                                const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Distances to a set of meshes for many points nearby: triangles in a grid of cubes. Immutable; reentrant.
class MeshDistance {
 public:
  /// Closed meshes are solids that a point can be inside of; open ones are sheets. Farther than `reach` mm (> 0)
  /// nothing is found.
  MeshDistance(const std::vector<TriangleMesh>& solids, const std::vector<TriangleMesh>& sheets, double reach);

  /// Distance to the nearest triangle, mm; nan beyond the reach. Negative inside of a solid.
  [[nodiscard]] double At(const Eigen::Vector3d& p) const;

 private:
  struct Triangle {
    Eigen::Vector3d a, b, c;
  };
  [[nodiscard]] bool IsInside(const Eigen::Vector3d& p) const;
  void Add(const TriangleMesh& mesh);
  void Sort();

  double reach_;
  std::vector<Triangle> triangles_;
  std::vector<Bvh> solids_;
  std::vector<Eigen::AlignedBox3d> boxes_;  ///< Of the solids.
  Eigen::AlignedBox3d box_;                 ///< Of everything.
  Eigen::Vector3i size_ = Eigen::Vector3i::Ones();
  std::vector<std::vector<std::uint32_t>> cubes_;
};

}  // namespace annulus
