#pragma once

#include <Eigen/Core>
#include <vector>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// The direction of the fine grooves of brushed metal at every vertex: along the part, which is where the surface
/// bends least (round a tube the normal turns fast, along it slowly; the direction of the smaller principal curvature
/// in magnitude, averaged over the faces around). Unit and perpendicular to the normal. Where the surface bends alike
/// in all directions (flat, round) grooves run horizontally. The sign is arbitrary. Requires finite vertices, valid
/// faces and a normal per vertex.
[[nodiscard]] std::vector<Eigen::Vector3d> GrooveDirections(const TriangleMesh& mesh,
                                                            const std::vector<Eigen::Vector3d>& normals);

}  // namespace annulus
