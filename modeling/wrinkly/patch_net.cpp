#include "modeling/wrinkly/patch_net.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace annulus {
namespace {

/// What stands for the points beyond a boundary.
enum class Beyond { kMirrored, kRepeated };

/// A cell's corner or a mirrored point; the point that it was mirrored from is its first share.
PointShares Taken(const PointShares& shares, Beyond beyond) {
  if (beyond == Beyond::kMirrored) return shares;
  return {{shares.front().point, 1.0}};
}

/// The mean of a cell's corners.
PointShares CentroidOf(const MeshCell& cell, Beyond beyond) {
  PointShares sum;
  for (const PointShares& corner : cell.corners) {
    const PointShares taken = Taken(corner, beyond);
    sum.insert(sum.end(), taken.begin(), taken.end());
  }
  for (PointShare& share : sum) share.weight /= static_cast<double>(cell.corners.size());
  return Merged(std::move(sum));
}

/// Halfway from a control point to what is beyond one of its sides.
PointShares SidePoint(const ControlMesh& mesh, PointIndex point, std::size_t direction, Beyond beyond) {
  const std::uint8_t slot = mesh.SlotOf(point, direction);
  const ControlLink& link = mesh.parts().points[ControlMesh::Index(point)].link[slot];
  if (link.kind == ControlLink::Kind::kClosed) {
    return CentroidOf(mesh.cells()[static_cast<std::size_t>(mesh.CellOf(point, direction))], beyond);
  }
  const bool is_point = link.kind == ControlLink::Kind::kPoint;
  PointShares shares = is_point ? PointShares{{link.point, 1.0}} : Taken(mesh.Mirrored(point, slot), beyond);
  for (PointShare& share : shares) share.weight *= 0.5;
  shares.push_back({point, 0.5});
  return Merged(std::move(shares));
}

PatchNet MakeNet(const ControlMesh& mesh, PointIndex point, Beyond beyond) {
  const auto corner = [&](std::size_t k) {
    return CentroidOf(mesh.cells()[static_cast<std::size_t>(mesh.CellOf(point, k))], beyond);
  };
  PatchNet net;
  net[1][1] = {{point, 1.0}};
  net[2][2] = corner(0);
  net[0][2] = corner(1);
  net[0][0] = corner(2);
  net[2][0] = corner(3);
  net[2][1] = SidePoint(mesh, point, 0, beyond);
  net[1][2] = SidePoint(mesh, point, 1, beyond);
  net[0][1] = SidePoint(mesh, point, 2, beyond);
  net[1][0] = SidePoint(mesh, point, 3, beyond);
  return net;
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

PatchNet NetOf(const ControlMesh& mesh, PointIndex point) { return MakeNet(mesh, point, Beyond::kMirrored); }

PatchNet ValueNetOf(const ControlMesh& mesh, PointIndex point) { return MakeNet(mesh, point, Beyond::kRepeated); }

}  // namespace annulus
