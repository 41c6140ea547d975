#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/prepared_scene.h"
#include "render/scene.h"

namespace annulus {

/// What takes the place of a lens of power P on one side of its sheet: a surface of curvature `curvature` at the
/// sheet's middle (1/mm, positive where it is convex towards the eye) before a medium of index `index`.
struct SheetPower {
  double index = 1.0;
  double curvature = 0.0;
};

/// Symbols: P the power, 1/mm; k = 1/r the sheet's own curvature towards the eye, 1/mm; d the distance of what lies
/// behind, mm.
/// kFilled (paper 000, §4: all behind the sheet is filled with the medium): P = k (n - 1) / n, so n = 1 / (1 - P / k).
///   Seen from far, the lateral magnification n / (n - d (n - 1) k) is that of a thin lens, 1 / (1 - d P), for every d.
/// kThin (the medium ends at the plane that touches the sheet's middle, without thickness): P = |n - 1| k with the
///   sign of P in the surface's curvature, so n = 1 + |P / k|: a minus lens is hollow, never thinner than air.
/// The index is kept within kLeastSheetIndex … kGreatestSheetIndex; what it cannot give, and all of a flat sheet, is
/// made up by the curvature, so that P holds at the middle for all -30 … 30 D. Power 0: index 1.
[[nodiscard]] SheetPower SheetPowerOf(double power_dioptre, double own_curvature, LensMedium medium);

inline constexpr double kLeastSheetIndex = 0.8;
inline constexpr double kGreatestSheetIndex = 1.5;

/// The sheet of a lens that refracts the rays from the eye (paper 000, §4). Camera frame of camera.h, mm.
class SheetLens {
 public:
  /// Of item `item` of a prepared scene. The middle is the sheet's centre of area, its axis the mean normal; the
  /// curvature there is the slope of the normals' lateral part over the lateral offset, fitted by least squares with
  /// weights that fall to 0 at the edge (of a sphere exactly 1 / r).
  SheetLens(const PreparedScene& prepared, std::size_t item, LensMedium medium);

  /// Whether rays go straight through.
  [[nodiscard]] bool IsPlano() const { return front_.index == 1.0; }
  /// Curvature about the middle, 1/mm; positive where convex on the side to which `axis` points.
  [[nodiscard]] double curvature() const { return curvature_; }
  [[nodiscard]] const Eigen::Vector3d& middle() const { return middle_; }
  [[nodiscard]] const Eigen::Vector3d& axis() const { return axis_; }

  /// The direction (unit) in which a ray of direction `direction` (unit) goes on from `p` on the sheet, where the
  /// sheet's unit normal on the ray's side is `normal`; nothing if it is totally reflected.
  [[nodiscard]] std::optional<Eigen::Vector3d> Refract(const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                                                       const Eigen::Vector3d& direction) const;

 private:
  LensMedium medium_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
  double curvature_ = 0.0;
  SheetPower front_;  // seen from where the axis points
  SheetPower back_;
};

}  // namespace annulus
