#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "base/units.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// Sum of the solid angles of a mesh's triangles over 4π (Van Oosterom and Strackee 1983): 1 inside, 0 outside.
inline double WindingNumber(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double sum = 0.0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]] - p;
    const Eigen::Vector3d b = mesh.vertices[face[1]] - p;
    const Eigen::Vector3d c = mesh.vertices[face[2]] - p;
    const double denominator =
        a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), denominator);
  }
  return sum / (4.0 * kPi);
}

}  // namespace annulus
