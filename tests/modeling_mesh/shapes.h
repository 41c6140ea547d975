#pragma once

#include <cmath>
#include <cstdint>

#include "base/units.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus::test_shapes {

/// An axis-aligned box, outward.
inline TriangleMesh Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back((corner & 1) != 0 ? high.x() : low.x(), (corner & 2) != 0 ? high.y() : low.y(),
                               (corner & 4) != 0 ? high.z() : low.z());
  }
  mesh.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A torus about the z axis: circle of radius `big`, tube of radius `small`, lying at z = 0.
inline TriangleMesh Torus(double big, double small, std::uint32_t around, std::uint32_t along) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double u = kTwoPi * i / around;
    for (std::uint32_t j = 0; j < along; ++j) {
      const double v = kTwoPi * j / along;
      const double r = big + small * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), small * std::sin(v));
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return (i % around) * along + j % along; };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < along; ++j) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace annulus::test_shapes
