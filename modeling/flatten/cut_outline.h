#pragma once

#include <Eigen/Core>
#include <vector>

namespace annulus {

/// A closed outline, counter-clockwise, moved outwards: side k (from point k to the next) by `distance[k]` >= 0, mm.
/// Corners are mitred, those that would stick out further than 2.5 times the distance bevelled; loops that arise in
/// tight hollows are cut off. Requires three points or more and as many distances.
[[nodiscard]] std::vector<Eigen::Vector2d> OffsetOutline(const std::vector<Eigen::Vector2d>& outline,
                                                         const std::vector<double>& distance);

}  // namespace annulus
