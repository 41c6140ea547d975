#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace annulus {

/// A convex polygon of at most 3 + 5 corners: a triangle cut at five planes.
struct ClipPolygon {
  std::array<Eigen::Vector3d, 8> corner;
  int count = 0;

  void Add(const Eigen::Vector3d& p) { corner[static_cast<std::size_t>(count++)] = p; }
};

/// Half space normal . p + offset >= 0.
struct ClipPlane {
  Eigen::Vector3d normal;
  double offset = 0.0;

  [[nodiscard]] double Distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset; }
};

/// What of `polygon` lies in the half space (Sutherland and Hodgman 1974). The crossing is always taken from the inner
/// end, so that the two faces of an edge get the same point.
[[nodiscard]] inline ClipPolygon ClipAt(const ClipPlane& plane, const ClipPolygon& polygon) {
  ClipPolygon clipped;
  for (int k = 0; k < polygon.count; ++k) {
    const Eigen::Vector3d& p = polygon.corner[static_cast<std::size_t>(k)];
    const Eigen::Vector3d& q = polygon.corner[static_cast<std::size_t>((k + 1) % polygon.count)];
    const double at_p = plane.Distance(p);
    const double at_q = plane.Distance(q);
    if (at_p >= 0.0) clipped.Add(p);
    if (at_p >= 0.0 && at_q < 0.0) clipped.Add(p + at_p / (at_p - at_q) * (q - p));
    if (at_p < 0.0 && at_q >= 0.0) clipped.Add(q + at_q / (at_q - at_p) * (p - q));
  }
  return clipped;
}

}  // namespace annulus
