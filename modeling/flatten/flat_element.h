#pragma once

#include <Eigen/Core>

#include "modeling/flatten/curved_sheet.h"

namespace annulus {

/// One triangle of constant strain. F maps the triangle on the body to the flat one; with F = V·R (polar decomposition)
/// the strain is V − 1 in the axes of the flat piece: the rotation is taken out, the stretch stays linear. Components:
/// weft V_xx − 1, warp V_yy − 1, shear angle 2·V_xy.
class FlatElement {
 public:
  /// Requires a triangle with area.
  explicit FlatElement(const LaidTriangle& laid);

  /// Flat corners, mm, one per column.
  using Corners = Eigen::Matrix<double, 2, 3>;
  /// (x0, y0, x1, y1, x2, y2)
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  [[nodiscard]] double area() const { return area_; }
  [[nodiscard]] Eigen::Matrix2d Gradient(const Corners& flat) const { return flat * slopes_.transpose(); }
  /// ∂F/∂corner: row k of the shape functions' slopes, 1/mm. Shape (2, 3).
  [[nodiscard]] const Eigen::Matrix<double, 2, 3>& slopes() const { return slopes_; }

  /// N·mm
  [[nodiscard]] double Energy(const Corners& flat, const Eigen::Matrix3d& stiffness) const;

  struct Expansion {
    double energy = 0.0;
    Vector6 gradient;
    Matrix6 hessian;
  };
  /// How the curvature of the energy is taken: as it is, or that part of it which is never negative, so that a step
  /// from anywhere goes down.
  enum class Curvature { kExact, kConvex };
  [[nodiscard]] Expansion Expand(const Corners& flat, const Eigen::Matrix3d& stiffness, Curvature curvature) const;

 private:
  Eigen::Matrix<double, 2, 3> slopes_;
  double area_ = 0.0;
};

/// (V_xx − 1, V_yy − 1, 2·V_xy) of F = V·R. Requires det F > 0.
[[nodiscard]] Eigen::Vector3d LinearStrain(const Eigen::Matrix2d& gradient);

/// The larger and the smaller principal value of a strain in these components.
[[nodiscard]] Eigen::Vector2d PrincipalStrains(const Eigen::Vector3d& strain);

}  // namespace annulus
