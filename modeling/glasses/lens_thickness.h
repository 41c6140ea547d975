#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/lens_surface.h"

namespace annulus {

/// One place on the edge of a lens.
struct EdgePoint {
  double angle = 0.0;  ///< rad, about the box centre, counter-clockwise from the viewer's right.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< Outline, lens frame, mm.
  double front_z = 0.0;                                ///< Front and back edge, lens frame, mm.
  double back_z = 0.0;
  [[nodiscard]] double thickness() const { return front_z - back_z; }  ///< Along z, mm.
};
/// The edge, every so many degrees. The extremes are those of these points.
struct LensEdge {
  std::vector<EdgePoint> points;
  double thinnest = 0.0;        ///< mm.
  double thinnest_angle = 0.0;  ///< rad.
  double thickest = 0.0;
  double thickest_angle = 0.0;
};
/// `count` points at equal angles. NaN where a surface does not reach. Requires a valid outline, count >= 3.
[[nodiscard]] LensEdge EdgeOf(const LensForm& form, const LensOutline& outline, std::size_t count);

/// The solid lens, its edge parallel to z.
struct LensBody {
  double volume = 0.0;                                          ///< mm³.
  double weight = 0.0;                                          ///< g.
  Eigen::Vector3d centre_of_gravity = Eigen::Vector3d::Zero();  ///< Lens frame, mm.
};
/// Gauss quadrature over the triangles from the box centre to the outline's sides. `density` in g/cm³.
[[nodiscard]] LensBody BodyOf(const LensForm& form, const LensOutline& outline, double density);

/// Thickness on a grid over the box.
struct ThicknessMap {
  double x0 = 0.0;  ///< Lens frame, mm: cell (0, 0) is at the box's lower left corner.
  double y0 = 0.0;
  double step = 0.0;          ///< mm.
  Eigen::MatrixXd thickness;  ///< (row y, column x), mm; NaN outside the outline.
};
/// Requires a valid outline, step > 0.
[[nodiscard]] ThicknessMap ThicknessMapOf(const LensForm& form, const LensOutline& outline, double step);

/// Whether a point lies inside the outline (about its box centre; the edge counts).
[[nodiscard]] bool Inside(const LensOutline& outline, const Eigen::Vector2d& point);

}  // namespace annulus
