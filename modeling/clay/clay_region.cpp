#include "modeling/clay/clay_region.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace annulus {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr std::uint32_t kDeepest = 10;
constexpr std::size_t kMostMade = 20'000;

AlignedBox3d BoxOf(const ClayPatch& patch) {
  AlignedBox3d box;
  for (const auto& row : patch.net) {
    for (const Vector3d& point : row) box.extend(point);
  }
  return box;
}

void AppendVertices(const ClayMesh& mesh, ClayRegion& region) {
  std::vector<bool> seen(mesh.vertex_slots(), false);
  for (const PatchIndex index : region.patches) {
    for (const VertexIndex vertex : mesh.patch(index).vertex) {
      if (!seen[vertex]) region.vertices.push_back(vertex);
      seen[vertex] = true;
    }
  }
}

}  // namespace

ClayRegion RegionAround(const ClayMesh& mesh, PatchIndex start, const Vector3d& centre, double radius) {
  ClayRegion region;
  std::vector<bool> seen(mesh.patches().size(), false);
  seen[start] = true;
  region.patches.push_back(start);
  for (std::size_t n = 0; n < region.patches.size(); ++n) {
    for (const ClayJoin& join : mesh.patch(region.patches[n]).join) {
      for (const PatchIndex other : join.patch) {
        if (other == kNoIndex || seen[other]) continue;
        seen[other] = true;
        if (BoxOf(mesh.patch(other)).squaredExteriorDistance(centre) > radius * radius) continue;
        region.patches.push_back(other);
      }
    }
  }
  AppendVertices(mesh, region);
  return region;
}

ClayRegion WholeBody(const ClayMesh& mesh) {
  ClayRegion region;
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (mesh.alive(index)) region.patches.push_back(index);
  }
  AppendVertices(mesh, region);
  return region;
}

Status RefineAround(ClayBody& body, const ClayAddress& address, const Vector3d& centre, double radius, double size) {
  const std::size_t most = body.mesh().leaf_count() + kMostMade;
  std::vector<PatchIndex> open = RegionAround(body.mesh(), body.mesh().Locate(address).patch, centre, radius).patches;
  for (std::size_t n = 0; n < open.size(); ++n) {
    // One that was cut with a finer one may be no more, or another that was made.
    if (!body.mesh().alive(open[n]) || body.mesh().patch(open[n]).level >= kDeepest) continue;
    const AlignedBox3d box = BoxOf(body.mesh().patch(open[n]));
    if (box.sizes().maxCoeff() <= size || box.squaredExteriorDistance(centre) > radius * radius) continue;
    const std::vector<PatchIndex> made = body.Split(open[n]);
    open.insert(open.end(), made.begin(), made.end());
    if (body.mesh().leaf_count() <= most) continue;
    return Fail("cut the clay as fine as the tool needs it",
                fmt::format("leaves of {:g} mm within {:g} mm are more than {}", size, radius, kMostMade),
                "take a larger tool, or let it reach less far");
  }
  return {};
}

}  // namespace annulus
