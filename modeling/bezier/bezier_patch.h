#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// Which way a patch is cut in two.
enum class PatchDirection { kU, kV };

/// Control points of a cubic Bezier curve.
using BezierCurve = std::array<Eigen::Vector3d, 4>;

/// Bicubic Bezier patch S(u, v) = Σ_i Σ_j B_i3(u) B_j3(v) Q_ij, 0 <= u, v <= 1 (paper 000, eqs. 1–5).
/// Immutable value; lengths are those of the control points (mm).
class BezierPatch {
 public:
  /// Q[i][j]: row i belongs to u, column j to v.
  using ControlNet = std::array<std::array<Eigen::Vector3d, 4>, 4>;

  explicit BezierPatch(const ControlNet& control_net) : control_net_(control_net) {}

  [[nodiscard]] const ControlNet& control_net() const { return control_net_; }
  /// Q_ij; i, j in 0 … 3. The four corners are on the surface (eq. 6).
  [[nodiscard]] const Eigen::Vector3d& control_point(std::size_t i, std::size_t j) const { return control_net_[i][j]; }

  /// S(u, v) by the Bernstein form (eqs. 1, 2).
  [[nodiscard]] Eigen::Vector3d Point(double u, double v) const;
  /// S(u, v) by the matrix form (eqs. 3–5); equal to Point up to rounding.
  [[nodiscard]] Eigen::Vector3d PointByMatrix(double u, double v) const;
  /// S_u and S_v.
  [[nodiscard]] Eigen::Vector3d DerivativeU(double u, double v) const;
  [[nodiscard]] Eigen::Vector3d DerivativeV(double u, double v) const;
  /// Unit normal along S_u × S_v. Where that vanishes (the corner of a lens: both edges share a tangent there) the
  /// limit on the way to the patch's centre; (0, 0, 1) if the whole patch has no area.
  [[nodiscard]] Eigen::Vector3d Normal(double u, double v) const;

  /// The two halves at parameter `at` (0 < at < 1), by de Casteljau: together the same surface.
  [[nodiscard]] std::pair<BezierPatch, BezierPatch> Split(PatchDirection direction, double at) const;

  /// The same surface with u and v exchanged, so that its normal points the other way.
  [[nodiscard]] BezierPatch Flipped() const;
  /// Mirrored at the plane x = 0, u and v exchanged so that an outward normal stays outward.
  [[nodiscard]] BezierPatch MirroredX() const;

 private:
  ControlNet control_net_;
};

/// The curve S(u, ·) of a patch, and its derivative by u, S_u(u, ·).
[[nodiscard]] BezierCurve CurveAtU(const BezierPatch& patch, double u);
[[nodiscard]] BezierCurve CurveChangeAtU(const BezierPatch& patch, double u);

/// (count_u + 1) · (count_v + 1) points of the patch joined to triangles whose normals follow S_u × S_v; an open sheet.
/// Requires counts >= 1.
[[nodiscard]] TriangleMesh Tessellate(const BezierPatch& patch, std::size_t count_u, std::size_t count_v);

/// The four cubic Bernstein polynomials B_i3(t) (eq. 2).
[[nodiscard]] std::array<double, 4> CubicBernstein(double t);

/// The point at `t` of the cubic Bezier curve with these control points.
[[nodiscard]] Eigen::Vector3d CubicBezierPoint(const BezierCurve& control, double t);
/// Its derivative at `t`.
[[nodiscard]] Eigen::Vector3d CubicBezierDerivative(const BezierCurve& control, double t);
/// Its length, by Gauss quadrature on eight pieces; relative error < 1e-6 for curves without cusps.
[[nodiscard]] double CubicBezierLength(const BezierCurve& control);
/// The same curve run through the other way.
[[nodiscard]] BezierCurve Backwards(const BezierCurve& curve);
/// The straight line as a curve of constant speed.
[[nodiscard]] BezierCurve StraightCurve(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
/// The two pieces at parameter `at` (0 < at < 1), by de Casteljau.
[[nodiscard]] std::pair<BezierCurve, BezierCurve> Split(const BezierCurve& curve, double at);

/// The patch with straight lines from `first` (u = 0) to `last` (u = 1), both along v; its edges are theirs to the bit.
[[nodiscard]] BezierPatch RuledPatch(const BezierCurve& first, const BezierCurve& last);

/// The four edges of a patch. first_u: u = 0, along v; last_u: u = 1, along v; first_v: v = 0, along u; last_v: v = 1,
/// along u. They meet at the corners.
struct PatchEdges {
  BezierCurve first_u;
  BezierCurve last_u;
  BezierCurve first_v;
  BezierCurve last_v;
};
/// The bilinearly blended Coons patch over these edges, which of cubic curves is bicubic; its edges are theirs to the
/// bit, the corners those of first_u and last_u.
[[nodiscard]] BezierPatch CoonsPatch(const PatchEdges& edges);

}  // namespace annulus
