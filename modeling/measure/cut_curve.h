#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "modeling/measure/cutting_plane.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

/// A point at which the curve surface ∩ plane is known, and how it goes on from there.
struct CutNode {
  double theta = 0.0;        ///< rad; not wrapped, so that turns about the axis can be counted.
  double z = 0.0;            ///< mm
  double along_theta = 0.0;  ///< Change of theta and z per mm along the curve.
  double along_z = 0.0;
  double across_theta = 0.0;  ///< The same, across the curve on the surface.
  double across_z = 0.0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  Eigen::Vector3d tangent = Eigen::Vector3d::Zero();   ///< Of unit length, in the direction of the walk.
};

/// A point between two nodes, parameter t = 0 … 1 of the piece.
struct CutSample {
  double theta = 0.0;  ///< rad, not wrapped
  double z = 0.0;      ///< mm
  double theta_by_t = 0.0;
  double z_by_t = 0.0;
  double height_by_theta = 0.0;  ///< Derivatives of the surface's height over the plane, mm/rad and mm/mm.
  double height_by_z = 0.0;
  double sine_squared = 0.0;                           ///< Of the angle between plane and surface.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< mm
  Eigen::Vector3d by_t = Eigen::Vector3d::Zero();      ///< d(position)/dt, mm
};

/// Which way along the curve (paper 001, fig. 3.5).
enum class CutDirection {
  kPlusLeft,   ///< ⊕ (CuttingPlane::Height > 0) on the left, seen from outside, as in the paper.
  kPlusRight,  ///< The other way.
};

/// Why a walk along the curve ended.
enum class CutEnd {
  kTarget,       ///< At one of the targets.
  kLeftRange,    ///< Below or above the surface.
  kBackAtStart,  ///< The curve is closed and passes no target.
  kTouches,      ///< The plane touches the surface there, so that the curve has no direction, or is endless.
};

/// Sine of the angle between plane and surface below which first-order movements of a curve are limited.
inline constexpr double kLimitedSine = 0.01;

/// A walk along the curve.
struct CutWalk {
  std::vector<CutNode> nodes;  ///< From the start; the last is the target, or the start again one turn on.
  CutEnd end = CutEnd::kTouches;
  std::size_t target = 0;  ///< Which, if it ended at one.
};

/// The curve in which a plane cuts the spline surface (paper 001, §3.1 (1)), followed on the spline itself: every node
/// is on both to 1e-9 mm. Nodes lie on all knot lines that are crossed (or within 0.01 mm), so that the curve is smooth
/// between them, at least 0.01 and at most 2 mm, a knot interval and 0.15 rad of turning apart. Borrows the
/// surface. Reentrant.
class CutCurve {
 public:
  CutCurve(const SplineSurface& surface, const CuttingPlane& plane) : surface_(&surface), plane_(plane) {}

  [[nodiscard]] const CuttingPlane& plane() const { return plane_; }
  /// Walks from a place on the curve until it meets one of `targets`, places on the plane.
  [[nodiscard]] CutWalk Walk(const SurfacePlace& start, CutDirection direction,
                             std::span<const SurfacePlace> targets) const;
  /// The curve between two successive nodes; from and to at t = 0 and 1.
  [[nodiscard]] CutSample Between(const CutNode& from, const CutNode& to, double t) const;
  /// Its length between successive nodes, all of them, mm: by 4 Gauss points a piece.
  [[nodiscard]] double Length(std::span<const CutNode> nodes) const;
  /// A point of the curve as one of a path that stays in the plane when the surface moves. Where the plane nearly
  /// touches the surface (below 0.01 rad), the movement is limited to that at 0.01 rad.
  [[nodiscard]] PathPoint InPlane(const SurfacePlace& place) const;
  /// How a point of the curve follows the plane's movement along its normal, the surface at rest; limited alike.
  [[nodiscard]] Eigen::Vector3d ByPlane(const SurfacePlace& place) const;

 private:
  /// The node there for a walk with ⊕ on the left (sign 1) or right (-1); nothing where the plane touches the surface.
  [[nodiscard]] std::optional<CutNode> NodeAt(double theta, double z, double sign) const;
  /// One step of about `length` mm; nothing if it was too long for a smooth piece.
  [[nodiscard]] std::optional<CutNode> Step(const CutNode& from, double length, double sign) const;
  /// The longest step that stays within a knot interval.
  [[nodiscard]] double LongestStep(const CutNode& node) const;
  /// Appends `to` and, before it, nodes on the knot lines that the piece crosses.
  void Append(std::vector<CutNode>& nodes, const CutNode& to, double sign) const;

  const SplineSurface* surface_;
  CuttingPlane plane_;
};

}  // namespace annulus
