#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// Which way a patch is cut in two.
enum class PatchDirection { kU, kV };

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

 private:
  ControlNet control_net_;
};

/// (count_u + 1) · (count_v + 1) points of the patch joined to triangles whose normals follow S_u × S_v; an open sheet.
/// Requires counts >= 1.
[[nodiscard]] TriangleMesh Tessellate(const BezierPatch& patch, std::size_t count_u, std::size_t count_v);

/// The four cubic Bernstein polynomials B_i3(t) (eq. 2).
[[nodiscard]] std::array<double, 4> CubicBernstein(double t);

/// The point at `t` of the cubic Bezier curve with these control points.
[[nodiscard]] Eigen::Vector3d CubicBezierPoint(const std::array<Eigen::Vector3d, 4>& control, double t);

}  // namespace annulus
