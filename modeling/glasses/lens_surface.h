#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace annulus {

/// One optical surface of a lens: a sphere or a torus, in the lens frame.
///
/// Lens frame: mm; x and y as in the lens's LensOutline (front view: x the wearer's left, y up), z forward, away from
/// the eye; z = 0 is the plane that touches the front surface at the box centre. An upright lens's (x, y, z) is
/// (−x, z, y) of the head or frame frame (x the wearer's right, y forward, z up). Surface frame: the vertex is the
/// origin, w the forward normal, u and v the principal meridians.
///
/// The torus is the tyre form: a circle of curvature `curvature_u` in the u–w plane turned about an axis that is
/// parallel to u and passes 1 / curvature_v behind the vertex; |curvature_u| >= |curvature_v| where this program makes
/// one. Equal curvatures are a sphere; 0 is flat. A curvature (1/mm) is positive if its centre is behind the surface,
/// on the eye's side: a convex front and the usual hollow back are both positive.
struct LensSurface {
  Eigen::Isometry3d lens_from_surface = Eigen::Isometry3d::Identity();
  double curvature_u = 0.0;
  double curvature_v = 0.0;

  /// How far the surface lies behind its vertex plane at (u, v), mm; NaN beyond its rim.
  [[nodiscard]] double SagInSurface(double u, double v) const;
  /// z at (x, y) of the lens frame, mm; NaN where the surface does not reach.
  [[nodiscard]] double Sag(double x, double y) const;
};

/// Where a line meets a surface, and what the surface is there, in the lens frame.
struct SurfaceHit {
  Eigen::Vector3d point;      ///< mm.
  Eigen::Vector3d normal;     ///< Unit, forward.
  Eigen::Matrix3d curvature;  ///< Shape operator: tᵀ·K·t is the normal curvature (1/mm) along the unit tangent t.
};
/// The meeting point on the side of the vertex; none if the line misses.
[[nodiscard]] std::optional<SurfaceHit> Meet(const LensSurface& surface, const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction);

/// The two surfaces of a lens and what lies between them.
struct LensForm {
  LensSurface front;
  LensSurface back;
  double index = 0.0;
  double centre_thickness = 0.0;                          ///< Along the optical axis at the reference point, mm.
  Eigen::Vector2d reference = Eigen::Vector2d::Zero();    ///< Optical centre (with prism: reference point), lens x, y.
  Eigen::Vector3d front_point = Eigen::Vector3d::Zero();  ///< Front surface there.
  Eigen::Vector3d back_point = Eigen::Vector3d::Zero();   ///< Back vertex.
  Eigen::Vector3d optical_axis = Eigen::Vector3d::UnitZ();  ///< The front normal at the reference point.

  /// Along z at (x, y), mm; NaN where a surface does not reach, negative where they have crossed.
  [[nodiscard]] double Thickness(double x, double y) const { return front.Sag(x, y) - back.Sag(x, y); }
};

}  // namespace annulus
