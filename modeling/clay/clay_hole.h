#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// Where a hole goes that begins at an address and leaves the body on the far side, along `inward` (unit): one leaf at
/// each end, for which the body is cut until both are of one rank and neither is wider than twice the square that has
/// the area of the circle of `radius` mm. The hole goes from the middle of the leaf that holds the address. Fails if
/// there is no far side, or no two leaves are found that lie opposite each other.
Result<ClayMesh::Hole> PlanHole(ClayBody& body, const ClayAddress& at, const Eigen::Vector3d& inward, double radius);

/// A hole as it is now.
struct HoleLine {
  Eigen::Vector3d from, to;         ///< Middles of its ends, mm.
  double radius_mm = 0.0;           ///< Of the circle that is as large as its narrower end, seen along the line.
  ClayAddress first, middle, last;  ///< On its wall.
};
/// Requires one whose rims and wall no other hole has cut: HasWholeRims.
[[nodiscard]] HoleLine LineOf(const ClayBody& body, std::size_t hole);

[[nodiscard]] bool HasWholeRims(const ClayMesh& mesh, std::size_t hole);

}  // namespace annulus
