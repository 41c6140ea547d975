#pragma once

#include <array>

#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// The control points of one patch as shares of the mesh's: a biquadratic Bezier net, [a][b] with a along U and b along
/// V of the patch's own axes (0 at their −, 2 at their + side).
using PatchNet = std::array<std::array<PointShares, 3>, 3>;

/// Paper 003, §3.4 with the ratios of DESIGN.md §5: in the middle the control point p, at the corners c the centroids
/// of the cells, at the sides e the points halfway to the neighbours, and where a side is closed the one cell's
/// centroid three times (figs. 10 b–d). Raised to bicubic this is the net with (c + 2e)/3 and (c + 2e_u + 2e_v + 4p)/9;
/// on a regular mesh it is the biquadratic B-spline. Requires HasPatch(point).
[[nodiscard]] PatchNet NetOf(const ControlMesh& mesh, PointIndex point);
/// The same for what points carry: beyond a boundary there is what is at the boundary, so that nothing exceeds what was
/// given.
[[nodiscard]] PatchNet ValueNetOf(const ControlMesh& mesh, PointIndex point);

/// `shares` with every point once, in ascending order.
[[nodiscard]] PointShares Merged(PointShares shares);

}  // namespace annulus
