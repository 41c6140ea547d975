#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace annulus {

/// A point of a surface over two parameters.
struct PatchPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< mm
  Eigen::Vector3d du = Eigen::Vector3d::Zero();     ///< mm per unit of u.
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();
};

/// A biquadratic Bezier patch, [a][b] with a along u. The degree-elevated nets of paper 003, §3.4 are these.
using BiquadraticNet = std::array<std::array<Eigen::Vector3d, 3>, 3>;
[[nodiscard]] PatchPoint PointOn(const BiquadraticNet& net, double u, double v);

/// A quarter of a patch whose corner (0, 0) is a cell of any number of control points, as a quarter of a Doo–Sabin
/// surface (D. Doo, M. Sabin 1978): biquadratic everywhere but in that corner, where infinitely many ever smaller
/// patches meet with a common tangent plane. x runs along the side to neighbour ring[1], y along that to ring.back().
struct RoundedCorner {
  std::vector<Eigen::Vector3d>
      ring;  ///< The cell: first the patch's own control point, then the others in their order.
  /// Neighbours of ring[0] further along x, of ring[1] further along x, of ring[0] along y, of ring.back() along y, of
  /// ring[0] along both.
  Eigen::Vector3d x0, x1, y0, y1, xy;

  /// Requires 0 <= x, y <= 1. In the very corner of an irregular cell du and dv are tangents of arbitrary length.
  [[nodiscard]] PatchPoint At(double x, double y) const;
};

/// Where corner `first` of a cell goes in a step of subdivision: to Σ_j w_j·corner_{first+j}, w_0 = 1/4 + 5/(4n),
/// w_j = (3 + 2·cos(2πj/n))/(4n). Requires a cell.
[[nodiscard]] Eigen::Vector3d DooSabinPoint(const std::vector<Eigen::Vector3d>& cell, std::size_t first);

}  // namespace annulus
