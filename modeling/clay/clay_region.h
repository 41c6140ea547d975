#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// Leaves, and the vertices that they meet at.
struct ClayRegion {
  std::vector<PatchIndex> patches;
  std::vector<VertexIndex> vertices;
};

/// The leaves that hang together with `start` and of which some control point's box is within `radius` mm of `centre`:
/// the other side of a thin limb belongs to it only if the skin between does. Costs what it finds.
[[nodiscard]] ClayRegion RegionAround(const ClayMesh& mesh, PatchIndex start, const Eigen::Vector3d& centre,
                                      double radius);

/// All leaves and vertices of a body.
[[nodiscard]] ClayRegion WholeBody(const ClayMesh& mesh);

/// Cuts the leaves within `radius` mm of `centre` that hang together with the address, until none is larger than `size`
/// mm (the longest side of its box) or cut more than ten times. Paper 004, §2.1: where the tool is smaller than a
/// patch. Fails if that makes more than 20,000 leaves more; the surface is what it was.
Status RefineAround(ClayBody& body, const ClayAddress& address, const Eigen::Vector3d& centre, double radius,
                    double size);

}  // namespace annulus
