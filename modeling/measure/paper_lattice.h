#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "base/result.h"
#include "modeling/measure/cut_path.h"

namespace annulus {

/// Number of angles m and levels n of a lattice.
struct LatticeSize {
  std::size_t angles = 180;
  std::size_t levels = 360;
};

/// A mesh of the lattice: the one with the lattice point (angle, level) at its lower left. `angle` is not wrapped.
struct LatticeCell {
  long angle = 0;
  long level = 0;
};

/// The lattice UW of paper 001, §3.1 (1): sample points of the surface at m angles from theta = 0 and n levels from
/// z_min to z_max, joined to meshes of four. Borrows the surface. Reentrant.
class PaperLattice {
 public:
  /// Requires angles >= 3 and levels >= 2.
  PaperLattice(const SplineSurface& surface, LatticeSize size);
  /// The angles and levels of the scan itself: those of the body's knowledge map.
  [[nodiscard]] static LatticeSize SizeOfScan(const MeasuredSurface& body);

  [[nodiscard]] const LatticeSize& size() const { return size_; }
  /// Of lattice point (angle, level), any angle: rad, not wrapped, and mm.
  [[nodiscard]] SurfacePlace Place(long angle, long level) const;
  /// Its point of the surface, station frame, mm.
  [[nodiscard]] Eigen::Vector3d Point(long angle, long level) const;
  /// The mesh that holds a place: U = [m theta/2 pi], W = [(n - 1)(z - z_min)/(z_max - z_min)].
  [[nodiscard]] LatticeCell CellAt(const SurfacePlace& place) const;
  [[nodiscard]] bool Has(const LatticeCell& cell) const;

 private:
  const SplineSurface* surface_;
  LatticeSize size_;
};

/// The four corners of a mesh, counter-clockwise from the lower left, seen from outside.
[[nodiscard]] std::array<LatticeCell, 4> CornersOf(const LatticeCell& cell);

/// A way from one click to another over the meshes that a clicked plane cuts.
struct LatticePath {
  ClickedPlane clicked;
  std::vector<LatticeCell> cells;  ///< Those of the first and last point included.
  std::vector<PathPoint> points;   ///< First point, crossings of mesh edges (eq. 3.4), last point. theta not wrapped.
  CutDirection direction = CutDirection::kPlusLeft;  ///< Which side ⊕ is on.
};

/// Follows the cut from mesh to mesh, from that of `via` both ways to those of `from` and `to` (paper 001, §3.1 (1)).
/// Where the mesh of a clicked place is not cut, since meshes are flatter than the surface, the nearest cut mesh stands
/// for it. Fails like CutThrough, and if the lattice is too coarse to tell the places apart.
[[nodiscard]] Result<LatticePath> LatticeCut(const MeasuredSurface& body, LatticeSize size,
                                             const std::array<Click, 3>& from_via_to);
/// The same along a view plane; which way is told as in CutInView.
[[nodiscard]] Result<LatticePath> LatticeViewCut(const MeasuredSurface& body, LatticeSize size,
                                                 const std::array<Click, 2>& from_to, const Eigen::Vector3d& view);

/// The polygon's length on the scan's own lattice. Fails if part of it was not seen.
[[nodiscard]] Result<SurfaceDistance> LatticeDistance(const MeasuredSurface& body, const Result<LatticePath>& path);

}  // namespace annulus
