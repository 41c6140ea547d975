#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace annulus {

/// How space moves at a place: by `move` mm, and near it by move + gradient·(p − place).
struct PointMotion {
  Eigen::Vector3d move = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
};

/// A field of motions, C1 in all of space. Positions in mm.
using ClayField = std::function<PointMotion(const Eigen::Vector3d&)>;

/// Where a tool acts and how it is held: `out` (unit) points away from the body, `along` (unit, across `out`) is the
/// long side of a spatula. Its footprint is an ellipse with these half axes, and how flat its bottom is: the dent's
/// depth at the relative radius q is 1 − q^(2·flatness): a finger's is 1, the parabola of paper 004 (eq. 9), a hand's
/// or a spatula's 3.
struct ToolPlace {
  Eigen::Vector3d origin;
  Eigen::Vector3d out;
  Eigen::Vector3d along;
  double radius_along = 1.0;   ///< mm, √(b/a) of eq. 9.
  double radius_across = 1.0;  ///< mm
  int flatness = 1;
  double reach = 1.0;  ///< mm along `out` to either side; to twice that the motion fades.
};

/// Dent of `depth` mm (b of eq. 9; negative: a bump), against `out`. Blended into the rim around q = 1, which the
/// paper's two parabolas do not meet at.
[[nodiscard]] ClayField DentField(const ToolPlace& place, double depth);

/// The rim (eq. 10) of height f = 1 mm: 1 − q²/rho², along `out`, from the dent's edge to q = rho, where it fades.
/// `rho`
/// (> 1) is √(f/e) over the tool's radius, the clay's material.
[[nodiscard]] ClayField RimField(const ToolPlace& place, double rho);

/// p − centre: the growth of all of space.
[[nodiscard]] ClayField ScaleField(const Eigen::Vector3d& centre);

/// A frame for what acts between two planes across an axis: at `origin` nothing moves yet, at origin + length·axis all
/// of it; before and behind it stays so.
struct AxisSpan {
  Eigen::Vector3d origin;
  Eigen::Vector3d axis;  ///< Unit.
  double length = 1.0;   ///< mm, > 0
};

/// Turns what is behind the span by `angle` rad about the axis, evenly in it, with soft ends.
[[nodiscard]] ClayField TwistField(const AxisSpan& span, double angle);
/// Lengthens the span by (factor − 1)·length: along the axis only.
[[nodiscard]] ClayField StretchField(const AxisSpan& span, double factor);
/// Away from the axis, in the span and fading over a fifth of it at both ends; 1 mm per mm of distance.
[[nodiscard]] ClayField GirthField(const AxisSpan& span);
/// The same within `radius` mm of the axis in full, fading to nothing at twice that.
[[nodiscard]] ClayField WidenField(const ToolPlace& place, double widening);

/// The same up to 1.25 radii; beyond, what is pushed aside gives way nearly without being pressed together, as 1/r, and
/// fades from 3 to 6 radii: room for a hole that becomes wider.
[[nodiscard]] ClayField MakeRoomField(const ToolPlace& place, double widening);

/// `amount` (0 … 1) of the way to the sphere about `centre`. Undefined at the centre, where it is 0.
[[nodiscard]] ClayField BallField(const Eigen::Vector3d& centre, double radius, double amount);

/// Flattens: towards the plane through the place across `out`, a factor `amount` of the height above or below it.
[[nodiscard]] ClayField FlattenField(const ToolPlace& place, double amount);

/// What is higher than the plane `depth` mm below the place comes down to it, softly over `softness` mm.
[[nodiscard]] ClayField ShaveField(const ToolPlace& place, double depth, double softness);

/// A sum of twelve waves of `wavelength` mm in random directions, its greatest motion about `amplitude` mm.
[[nodiscard]] ClayField KneadField(double amplitude, double wavelength, std::uint64_t seed);

}  // namespace annulus
