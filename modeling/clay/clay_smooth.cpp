#include "modeling/clay/clay_smooth.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a group sees: the groups at the other ends of its edges, its edges' first control points, its normal.
struct Surroundings {
  std::vector<VertexIndex> neighbour;
  std::vector<Vector3d> step;  ///< From the group's place to the edge's next control point.
  Vector3d normal = Vector3d::Zero();
};

Surroundings SurroundingsOf(const ClayMesh& mesh, VertexIndex vertex) {
  Surroundings seen;
  const Vector3d& place = mesh.Position(vertex);
  for (const PatchCorner& at : mesh.vertex(vertex).corners) {
    const ClayPatch& patch = mesh.patch(at.patch);
    const auto [i, j] = NetIndex(at.corner, 1, 0);
    const auto [k, l] = NetIndex(at.corner, 0, 1);
    const Vector3d along = patch.net[i][j] - place;
    seen.normal += along.cross(patch.net[k][l] - place);
    if (patch.join[at.corner].kind == ClayJoin::Kind::kPole) continue;
    seen.neighbour.push_back(patch.vertex[(at.corner + 1U) % 4]);
    seen.step.push_back(along);
  }
  seen.normal.normalize();
  return seen;
}

double ShareAt(const std::vector<SmoothSpot>& spots, const Vector3d& place) {
  double share = 0.0;
  for (const SmoothSpot& spot : spots) {
    const double q = (place - spot.centre).norm() / spot.radius_mm;
    const double t = std::clamp(2.0 - 2.0 * q, 0.0, 1.0);
    share = std::max(share, t * t * (3.0 - 2.0 * t));
  }
  return share;
}

/// The linear map that takes each step nearest to its wish, and the normal to what their plane then has.
Matrix3d BestMap(const std::vector<Vector3d>& step, const std::vector<Vector3d>& wish, const Vector3d& normal) {
  Matrix3d from = Matrix3d::Zero();
  Matrix3d to = Matrix3d::Zero();
  double size = 0.0;
  for (std::size_t n = 0; n < step.size(); ++n) {
    from += step[n] * step[n].transpose();
    to += wish[n] * step[n].transpose();
    size += step[n].squaredNorm();
  }
  // The normal's own size takes part as one more step, so that the map is whole in all directions.
  from += size * normal * normal.transpose();
  to += size * normal * normal.transpose();
  if (!(std::abs(from.determinant()) > 1e-9 * size * size * size)) return Matrix3d::Identity();
  return to * from.inverse();
}

}  // namespace

Result<ClayChange> SmoothOnce(ClayBody& body, const std::vector<SmoothSpot>& spots, double amount,
                              const MaskWeight& mask) {
  std::vector<ClayBody::FormerLeaf> former;
  for (const SmoothSpot& spot : spots) {
    const auto more = CoarsenAround(body, {spot.at, spot.centre, spot.radius_mm, 0.5 * spot.radius_mm});
    former.insert(former.end(), more.begin(), more.end());
  }
  const ClayMesh& mesh = body.mesh();
  std::vector<VertexIndex> vertices;
  std::unordered_set<VertexIndex> held;
  for (const SmoothSpot& spot : spots) {
    const PatchIndex start = mesh.Locate(spot.at).patch;
    for (const VertexIndex vertex : RegionAround(mesh, start, spot.centre, spot.radius_mm).vertices) {
      if (held.insert(vertex).second) vertices.push_back(vertex);
    }
  }
  std::unordered_map<VertexIndex, Vector3d> moved;
  const auto move_of = [&](VertexIndex vertex) -> Vector3d {
    const auto found = moved.find(vertex);
    return found == moved.end() ? Vector3d::Zero() : found->second;
  };
  std::vector<Surroundings> seen;
  for (const VertexIndex vertex : vertices) {
    Surroundings around = SurroundingsOf(mesh, vertex);
    Vector3d mean = Vector3d::Zero();
    for (const VertexIndex other : around.neighbour) mean += mesh.Position(other);
    const Vector3d& place = mesh.Position(vertex);
    const double share = amount * ShareAt(spots, place);
    if (!around.neighbour.empty() && share > 0.0) {
      moved[vertex] = share * (mean / static_cast<double>(around.neighbour.size()) - place);
    }
    seen.push_back(std::move(around));
  }
  ClayDeformation deformation;
  for (std::size_t n = 0; n < vertices.size(); ++n) {
    const Vector3d& place = mesh.Position(vertices[n]);
    const double share = ShareAt(spots, place);
    if (share <= 0.0) continue;
    std::vector<Vector3d> wish;
    for (std::size_t e = 0; e < seen[n].step.size(); ++e) {
      const VertexIndex other = seen[n].neighbour[e];
      const Vector3d way = mesh.Position(other) + move_of(other) - place - move_of(vertices[n]);
      wish.push_back(seen[n].step[e] + amount * share * (way / 3.0 - seen[n].step[e]));
    }
    PointMotion direct{move_of(vertices[n]), BestMap(seen[n].step, wish, seen[n].normal) - Matrix3d::Identity()};
    PointMotion indirect{share * seen[n].normal, Matrix3d::Zero()};
    if (!mask.empty()) {
      direct = mask.Weigh(place, direct);
      indirect = mask.Weigh(place, indirect);
    }
    deformation.direct.push_back({vertices[n], direct.move, direct.gradient});
    deformation.indirect.push_back({vertices[n], indirect.move, indirect.gradient});
  }
  auto change = body.Deform(deformation, VolumeRule::kKept);
  if (!change) body.Restore(former);
  return change;
}

}  // namespace annulus
