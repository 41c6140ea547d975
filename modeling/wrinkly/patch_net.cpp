#include "modeling/wrinkly/patch_net.h"

#include <algorithm>
#include <cstddef>

namespace annulus {
namespace {

/// Halfway from a control point to what is beyond one of its sides.
PointShares SidePoint(const ControlMesh& mesh, PointIndex point, std::size_t direction) {
  const std::uint8_t slot = mesh.SlotOf(point, direction);
  const ControlLink& link = mesh.parts().points[ControlMesh::Index(point)].link[slot];
  PointShares beyond;
  switch (link.kind) {
    case ControlLink::Kind::kPoint:
      beyond = {{link.point, 1.0}};
      break;
    case ControlLink::Kind::kBoundary:
      beyond = mesh.Mirrored(point, slot);
      break;
    case ControlLink::Kind::kClosed:
      return CentroidOf(mesh.cells()[static_cast<std::size_t>(mesh.CellOf(point, direction))]);
  }
  for (PointShare& share : beyond) share.weight *= 0.5;
  beyond.push_back({point, 0.5});
  return Merged(std::move(beyond));
}

}  // namespace

PointShares Merged(PointShares shares) {
  std::sort(shares.begin(), shares.end(), [](const PointShare& a, const PointShare& b) { return a.point < b.point; });
  PointShares merged;
  for (const PointShare& share : shares) {
    if (!merged.empty() && merged.back().point == share.point) {
      merged.back().weight += share.weight;
    } else {
      merged.push_back(share);
    }
  }
  std::erase_if(merged, [](const PointShare& share) { return share.weight == 0.0; });
  return merged;
}

PointShares CentroidOf(const MeshCell& cell) {
  PointShares sum;
  for (const PointShares& corner : cell.corners) sum.insert(sum.end(), corner.begin(), corner.end());
  for (PointShare& share : sum) share.weight /= static_cast<double>(cell.corners.size());
  return Merged(std::move(sum));
}

PatchNet NetOf(const ControlMesh& mesh, PointIndex point) {
  const auto corner = [&](std::size_t k) {
    return CentroidOf(mesh.cells()[static_cast<std::size_t>(mesh.CellOf(point, k))]);
  };
  PatchNet net;
  net[1][1] = {{point, 1.0}};
  net[2][2] = corner(0);
  net[0][2] = corner(1);
  net[0][0] = corner(2);
  net[2][0] = corner(3);
  net[2][1] = SidePoint(mesh, point, 0);
  net[1][2] = SidePoint(mesh, point, 1);
  net[0][1] = SidePoint(mesh, point, 2);
  net[1][0] = SidePoint(mesh, point, 3);
  return net;
}

}  // namespace annulus
