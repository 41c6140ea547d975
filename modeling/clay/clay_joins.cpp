#include "modeling/clay/clay_joins.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "modeling/clay/edge_place.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using Kind = ClayJoin::Kind;

/// Four patches with an edge between each two, or the two beside the middle of a coarser one's edge.
bool IsRegular(const ClayMesh& mesh, VertexIndex vertex) {
  const ClayVertex& at = mesh.vertex(vertex);
  if (at.corners.size() != (at.hanging ? 2U : 4U)) return false;
  return std::none_of(at.corners.begin(), at.corners.end(), [&mesh](const PatchCorner& corner) {
    const auto& join = mesh.patch(corner.patch).join;
    return join[corner.corner].kind == Kind::kPole || join[(corner.corner + 3U) % 4].kind == Kind::kPole;
  });
}

constexpr std::array<double, 5> kPlaces{0.0, 0.2, 0.5, 0.75, 1.0};
constexpr double kOnePlane = 1e-3;  ///< rad

/// What is found along one join.
struct JoinSeen {
  double gap = 0.0;
  double kink = 0.0;
  double kink_at_ends = 0.0;
};

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

JoinSeen SeenAlong(const ClayMesh& mesh, const ClayPatch& leaf, std::size_t edge) {
  const ClayJoin& join = leaf.join[edge];
  const BezierPatch own(leaf.net);
  const BezierPatch other(mesh.patch(join.patch[0]).net);
  JoinSeen seen;
  for (const double along : kPlaces) {
    const double theirs = join.kind == Kind::kEqual ? 1.0 - along : 0.5 * (1.0 - along) + 0.5 * join.half;
    const auto [u, v] = EdgePlace(edge, along);
    const auto [s, t] = EdgePlace(join.edge[0], theirs);
    const double angle = AngleBetween(own.Normal(u, v), other.Normal(s, t));
    seen.gap = std::max(seen.gap, (own.Point(u, v) - other.Point(s, t)).norm());
    seen.kink = std::max(seen.kink, angle);
    if (along == kPlaces.front() || along == kPlaces.back()) seen.kink_at_ends = std::max(seen.kink_at_ends, angle);
  }
  return seen;
}

}  // namespace

ClayJoinQuality MeasureJoins(const ClayMesh& mesh) {
  ClayJoinQuality quality;
  const auto widen = [](double& largest, double seen) { largest = std::max(largest, seen); };
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    const ClayPatch& leaf = mesh.patch(index);
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const ClayJoin& join = leaf.join[edge];
      // Each join from one of its sides.
      if (join.kind != Kind::kCoarser && (join.kind != Kind::kEqual || join.patch[0] < index)) continue;
      const JoinSeen seen = SeenAlong(mesh, leaf, edge);
      widen(quality.largest_gap_mm, seen.gap);
      if (!join.smooth) {
        if (seen.kink_at_ends <= kOnePlane) widen(quality.largest_kink_not_c1_rad, seen.kink);
        continue;
      }
      const bool regular = IsRegular(mesh, leaf.vertex[edge]) && IsRegular(mesh, leaf.vertex[(edge + 1) % 4]);
      widen(regular ? quality.largest_kink_rad : quality.largest_kink_elsewhere_rad, seen.kink);
    }
  }
  return quality;
}

}  // namespace annulus
