#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// A piece of a surface as its triangles measure it: how long their sides are, not how they lie in space. Lengths of
/// geodesics keep a cylinder or cone flat whatever its triangles are; lengths of chords do for plain meshes.
struct CurvedSheet {
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< Counter-clockwise seen from outside.
  std::vector<std::array<double, 3>> lengths;       ///< Per face, of the side from corner k to the next, mm.
  std::vector<Eigen::Vector3d> places;              ///< Of the vertices, station frame, mm; for pictures only.
};

/// A mesh's own triangles, sides as long as they are in space.
[[nodiscard]] CurvedSheet SheetOfMesh(const TriangleMesh& mesh);

/// A triangle laid into the plane: corner 0 at the origin, 1 on the positive x axis, 2 above it.
struct LaidTriangle {
  double base = 0.0;  ///< x of corner 1, mm.
  Eigen::Vector2d apex = Eigen::Vector2d::Zero();

  [[nodiscard]] double Area() const { return 0.5 * base * apex.y(); }
};
/// Requires sides that make a triangle (CheckSheet).
[[nodiscard]] LaidTriangle LayTriangle(const std::array<double, 3>& lengths);

/// How the faces of a sheet hang together.
struct SheetTopology {
  std::vector<std::vector<std::uint32_t>> rims;     ///< Closed chains of vertices, the sheet at their left.
  std::vector<std::uint32_t> part_of_vertex;        ///< Which connected part a vertex belongs to.
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< Each side of a triangle once, smaller vertex first.
  std::size_t parts = 0;
};

/// Fails unless every part of the sheet can be laid flat in one piece: triangles with positive area, at most two at a
/// side and turned alike, no vertex where only a point joins, one rim per part and no handle.
[[nodiscard]] Result<SheetTopology> CheckSheet(const CurvedSheet& sheet);

/// 2π less the angles around each vertex, rad: the curvature that is gathered there; 0 for vertices on a rim.
[[nodiscard]] std::vector<double> AngleDefects(const CurvedSheet& sheet, const SheetTopology& topology);

/// Total area of the triangles, mm².
[[nodiscard]] double SheetArea(const CurvedSheet& sheet);

}  // namespace annulus
