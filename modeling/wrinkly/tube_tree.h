#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// A tube of control points: its rings from the root to the tip, each with as many points, which run clockwise seen
/// from the tip (so that the tube's outside is outside).
using TubeRings = std::vector<std::vector<Eigen::Vector3d>>;

/// Where a tube begins.
struct TubeSlit {
  std::size_t tube = 0;    ///< The one that it leaves.
  std::size_t ring = 0;    ///< The slit runs between this ring and the next.
  std::size_t column = 0;  ///< Its first column; half as many as the new tube has points per ring.
};

/// Builds a control mesh of tubes that leave one another through slits. Where a tube of 2k points per ring leaves, k
/// links between two rings are taken apart and its first ring is put between; at the slit's two ends cells of six
/// points arise, everywhere else the mesh is regular: rings are U or V axes, and the two families stay apart. Both ends
/// of the first tube and the tips of all others are closed as ring nets are.
class TubeTree {
 public:
  /// Requires rings of one size, three points or more each, at least two rings.
  explicit TubeTree(const TubeRings& root);
  /// Adds a tube; returns its number. Requires an even number of points per ring, a slit within the rings of its tube
  /// and none there yet.
  std::size_t Add(const TubeSlit& slit, const TubeRings& rings);

  /// Number of a tube's control point.
  [[nodiscard]] PointIndex PointOf(std::size_t tube, std::size_t ring, std::size_t column) const;
  [[nodiscard]] const Eigen::Vector3d& PositionOf(std::size_t tube, std::size_t ring, std::size_t column) const;
  /// The mesh so far; heights 0.
  [[nodiscard]] ControlMeshParts Parts() const;

 private:
  struct Tube {
    std::size_t first = 0;
    std::size_t columns = 0;
    std::size_t rings = 0;
  };
  void AddRings(const TubeRings& rings);

  std::vector<Tube> tubes_;
  std::vector<ControlPoint> points_;
};

}  // namespace annulus
