#pragma once

#include <Eigen/Core>
#include <vector>

namespace annulus {

/// Corners of the convex hull of finite points, counter-clockwise, starting at the smallest x (then y); points on an
/// edge are left out. Fewer than three corners if the points are on a line. Andrew's monotone chain (1979), O(n log n).
[[nodiscard]] std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points);

/// Length of the hull's outline: what a tape measures. Twice the distance for two corners, 0 for fewer.
[[nodiscard]] double ConvexHullPerimeter(const std::vector<Eigen::Vector2d>& points);

}  // namespace annulus
