#include "modeling/clay/clay_joins.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;
using Kind = ClayJoin::Kind;

/// (u, v) at `along` (0 … 1) of an edge.
std::array<double, 2> OnEdge(std::size_t edge, double along) {
  switch (edge) {
    case 0:
      return {along, 0.0};
    case 1:
      return {1.0, along};
    case 2:
      return {1.0 - along, 1.0};
    default:
      return {0.0, 1.0 - along};
  }
}

/// Four patches with an edge between each two, or the two beside the middle of a coarser one's edge.
bool IsRegular(const ClayMesh& mesh, VertexIndex vertex) {
  const ClayVertex& at = mesh.vertex(vertex);
  if (at.corners.size() != (at.hanging ? 2U : 4U)) return false;
  return std::none_of(at.corners.begin(), at.corners.end(), [&mesh](const PatchCorner& corner) {
    const auto& join = mesh.patch(corner.patch).join;
    return join[corner.corner].kind == Kind::kPole || join[(corner.corner + 3U) % 4].kind == Kind::kPole;
  });
}

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

ClayJoinQuality MeasureJoins(const ClayMesh& mesh) {
  constexpr std::array<double, 5> kPlaces{0.0, 0.2, 0.5, 0.75, 1.0};
  ClayJoinQuality quality;
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    const ClayPatch& leaf = mesh.patch(index);
    const BezierPatch own(leaf.net);
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const ClayJoin& join = leaf.join[edge];
      // Each join from one of its sides.
      if (join.kind != Kind::kCoarser && (join.kind != Kind::kEqual || join.patch[0] < index)) continue;
      const BezierPatch other(mesh.patch(join.patch[0]).net);
      const bool regular = IsRegular(mesh, leaf.vertex[edge]) && IsRegular(mesh, leaf.vertex[(edge + 1) % 4]);
      double& kink = regular ? quality.largest_kink_rad : quality.largest_kink_elsewhere_rad;
      for (const double along : kPlaces) {
        const double theirs = join.kind == Kind::kEqual ? 1.0 - along : 0.5 * (1.0 - along) + 0.5 * join.half;
        const auto [u, v] = OnEdge(edge, along);
        const auto [s, t] = OnEdge(join.edge[0], theirs);
        quality.largest_gap_mm = std::max(quality.largest_gap_mm, (own.Point(u, v) - other.Point(s, t)).norm());
        if (join.smooth) kink = std::max(kink, AngleBetween(own.Normal(u, v), other.Normal(s, t)));
      }
    }
  }
  return quality;
}

}  // namespace annulus
