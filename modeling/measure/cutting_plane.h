#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A plane, station frame: normal · p = offset.
struct CuttingPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< Of unit length.
  double offset = 0.0;                                ///< mm

  /// Signed distance of a point, mm: positive where the paper writes ⊕ (left side of eq. 3.1 greater than the right).
  [[nodiscard]] double Height(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

/// A place of the surface that was clicked, and what messages call it ("A", "the point of --via").
struct Click {
  std::string name;
  SurfacePlace place;
};

/// A point and what messages call it; station frame, mm.
struct NamedPoint {
  std::string name;
  Eigen::Vector3d position;
};

/// The plane through three points (paper 001, eq. 3.1: normal (A - C) × (B - C)). Fails if two of them coincide or all
/// lie on one line, naming them.
[[nodiscard]] Result<CuttingPlane> PlaneThrough(const NamedPoint& a, const NamedPoint& b, const NamedPoint& c);

/// The plane through two points that is seen as their straight connection by one who looks along `view` (paper 001, eq.
/// 3.10: normal (B - A) × V, offset A · (B × V)). Fails if the points coincide, or if `view` is zero, not finite, or
/// along their connection.
[[nodiscard]] Result<CuttingPlane> ViewPlane(const NamedPoint& a, const NamedPoint& b, const Eigen::Vector3d& view);

/// A plane that clicked places span, and how it follows them when the surface moves.
class ClickedPlane {
 public:
  /// The plane through three clicked places. Fails like PlaneThrough, and for a click that CheckPlace refuses.
  static Result<ClickedPlane> Through(const MeasuredSurface& body, const std::array<Click, 3>& clicks);
  /// The view plane of two clicked places; `view` does not move. Fails like ViewPlane and Through.
  static Result<ClickedPlane> InView(const MeasuredSurface& body, const std::array<Click, 2>& clicks,
                                     const Eigen::Vector3d& view);

  [[nodiscard]] const CuttingPlane& plane() const { return plane_; }
  /// Position of corner 0 … 2, station frame, mm; the third of a view plane is the first moved along the view.
  [[nodiscard]] const Eigen::Vector3d& corner(std::size_t k) const { return corners_[k]; }
  /// At a point of the plane: how far the plane moves along its normal there if corner k moves by one along it.
  [[nodiscard]] Eigen::Vector3d Shares(const Eigen::Vector3d& point) const;
  /// Adds to `gradient` what a number depends on the plane: `by_corner`[k] is its derivative by the movement of corner
  /// k along the normal. The corners move with the radius at their places.
  void AddMovement(const Eigen::Vector3d& by_corner, GradientSum& gradient) const;

 private:
  CuttingPlane plane_;
  std::array<Eigen::Vector3d, 3> corners_{};
  std::array<SurfacePlace, 3> follows_{};
};

/// CheckPlace of a click, naming it.
Status CheckClick(const MeasuredSurface& body, const Click& click, const std::string& attempted);

}  // namespace annulus
