#include "modeling/mesh/convex_hull_2d.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace annulus {
namespace {

// Twice the area of the triangle, positive when it turns left at `middle`.
double Turn(const Eigen::Vector2d& from, const Eigen::Vector2d& middle, const Eigen::Vector2d& to) {
  const Eigen::Vector2d u = middle - from;
  const Eigen::Vector2d v = to - from;
  return u.x() * v.y() - u.y() * v.x();
}

// Extends one chain by `point`; corners below `fixed` stay.
void ExtendChain(std::vector<Eigen::Vector2d>& chain, std::size_t fixed, const Eigen::Vector2d& point) {
  while (chain.size() >= fixed + 2 && Turn(chain[chain.size() - 2], chain.back(), point) <= 0.0) chain.pop_back();
  chain.push_back(point);
}

}  // namespace

std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  for (const Eigen::Vector2d& point : points) ExtendChain(hull, 0, point);
  const std::size_t lower = hull.size() - 1;  // the right-most corner starts the upper chain
  for (std::size_t i = points.size() - 1; i-- > 0;) ExtendChain(hull, lower, points[i]);
  hull.pop_back();  // the first corner again
  return hull;
}

double ConvexHullPerimeter(const std::vector<Eigen::Vector2d>& points) {
  const std::vector<Eigen::Vector2d> hull = ConvexHull(points);
  double length = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) length += (hull[(i + 1) % hull.size()] - hull[i]).norm();
  return length;
}

}  // namespace annulus
