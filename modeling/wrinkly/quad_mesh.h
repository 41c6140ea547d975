#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// Quadrilaterals over shared vertices, counter-clockwise seen from outside, mm. A plain value; nothing is checked.
struct QuadMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 4>> quads;
};

/// The control mesh of which each quadrilateral is one patch: the control point stands in its middle, the vertices
/// become the cells. Sides whose ends are one vertex are closed. Heights are 0. Fails, naming the face, on an index out
/// of range, an edge of more than two faces, and faces that run along a common edge the same way.
[[nodiscard]] Result<ControlMeshParts> ControlMeshOfQuads(const QuadMesh& mesh);

/// What becomes of faces that have not four corners.
enum class PolygonRule {
  kRefuse,
  /// Every face of the mesh is cut into as many quadrilaterals as it has corners, from its middle to the middles of its
  /// edges: patches of any number of sides, which the paper leaves open.
  kSplit,
};

/// Reads vertices and faces of a Wavefront OBJ file; other lines are skipped, vertices without a face too. Fails, with
/// the line, on a face that is not a quadrilateral (kRefuse) or has fewer than three corners. `what` names the input in
/// messages.
[[nodiscard]] Result<QuadMesh> QuadMeshFromObj(std::string_view text, const std::string& what, PolygonRule rule);

}  // namespace annulus
