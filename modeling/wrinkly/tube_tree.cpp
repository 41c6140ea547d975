#include "modeling/wrinkly/tube_tree.h"

#include "base/ensure.h"

namespace annulus {
namespace {

/// Sides of a tube's control points: to the tip, on along the ring, to the root, back along the ring.
constexpr std::uint8_t kToTip = 0;
constexpr std::uint8_t kOnward = 1;
constexpr std::uint8_t kToRoot = 2;

void Join(std::vector<ControlPoint>& points, std::size_t from, std::uint8_t slot, std::size_t to, std::uint8_t back) {
  points[from].link[slot] = {ControlLink::Kind::kPoint, back, static_cast<PointIndex>(to)};
  points[to].link[back] = {ControlLink::Kind::kPoint, slot, static_cast<PointIndex>(from)};
}

}  // namespace

TubeTree::TubeTree(const TubeRings& root) {
  AddRings(root);
  for (std::size_t column = 0; column < tubes_[0].columns; ++column) {
    points_[column].link[kToRoot].kind = ControlLink::Kind::kClosed;
  }
}

void TubeTree::AddRings(const TubeRings& rings) {
  ENSURE(rings.size() >= 2 && rings.front().size() >= 3, "a tube has rings of three points or more");
  const Tube tube{points_.size(), rings.front().size(), rings.size()};
  for (const auto& ring : rings) {
    ENSURE(ring.size() == tube.columns, "all rings of a tube have as many points");
    for (const Eigen::Vector3d& position : ring) points_.push_back({position, {}, false});
  }
  for (std::size_t ring = 0; ring < tube.rings; ++ring) {
    for (std::size_t column = 0; column < tube.columns; ++column) {
      const std::size_t k = tube.first + ring * tube.columns + column;
      Join(points_, k, kOnward, tube.first + ring * tube.columns + (column + 1) % tube.columns, kOnward + 2);
      if (ring + 1 < tube.rings) {
        Join(points_, k, kToTip, k + tube.columns, kToRoot);
      } else {
        points_[k].link[kToTip].kind = ControlLink::Kind::kClosed;
      }
    }
  }
  tubes_.push_back(tube);
}

std::size_t TubeTree::Add(const TubeSlit& slit, const TubeRings& rings) {
  ENSURE(slit.tube < tubes_.size() && slit.ring + 1 < tubes_[slit.tube].rings, "a slit lies between two rings");
  const std::size_t width = rings.front().size() / 2;
  ENSURE(2 * width == rings.front().size() && width <= tubes_[slit.tube].columns, "a slit has two equal sides");
  AddRings(rings);
  const std::size_t number = tubes_.size() - 1;
  for (std::size_t k = 0; k < width; ++k) {
    const std::size_t column = (slit.column + k) % tubes_[slit.tube].columns;
    const auto below = static_cast<std::size_t>(PointOf(slit.tube, slit.ring, column));
    const auto above = static_cast<std::size_t>(PointOf(slit.tube, slit.ring + 1, column));
    ENSURE(points_[below].link[kToTip].point == static_cast<PointIndex>(above), "a slit is cut once");
    Join(points_, below, kToTip, static_cast<std::size_t>(PointOf(number, 0, k)), kToRoot);
    // Beyond the slit's far end the ring comes back along the other side.
    Join(points_, above, kToRoot, static_cast<std::size_t>(PointOf(number, 0, 2 * width - 1 - k)), kToRoot);
  }
  return number;
}

PointIndex TubeTree::PointOf(std::size_t tube, std::size_t ring, std::size_t column) const {
  return static_cast<PointIndex>(tubes_[tube].first + ring * tubes_[tube].columns + column);
}

const Eigen::Vector3d& TubeTree::PositionOf(std::size_t tube, std::size_t ring, std::size_t column) const {
  return points_[ControlMesh::Index(PointOf(tube, ring, column))].position;
}

ControlMeshParts TubeTree::Parts() const {
  ControlMeshParts parts;
  parts.points = points_;
  parts.values = decltype(parts.values)::Zero(static_cast<Eigen::Index>(points_.size()), 1);
  return parts;
}

}  // namespace annulus
