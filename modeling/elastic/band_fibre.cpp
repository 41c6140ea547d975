#include "modeling/elastic/band_fibre.h"

#include <algorithm>
#include <numeric>

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Indices of the hull's corners, counter-clockwise (Andrew's monotone chain).
std::vector<std::size_t> HullCorners(const std::vector<Vector2d>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].x() != points[b].x() ? points[a].x() < points[b].x() : points[a].y() < points[b].y();
  });
  std::vector<std::size_t> hull;
  const auto extend = [&](std::size_t next, std::size_t keep) {
    while (hull.size() >= keep + 2 &&
           !(Cross(points[hull.back()] - points[hull[hull.size() - 2]], points[next] - points[hull.back()]) > 0.0)) {
      hull.pop_back();
    }
    hull.push_back(next);
  };
  for (const std::size_t next : order) extend(next, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t n = order.size(); n-- > 0;) {
    if (n + 1 < order.size()) extend(order[n], lower);
  }
  hull.pop_back();  // the first again
  return hull;
}

std::vector<HullSide> SidesOf(const BandFibre& fibre, const std::vector<Vector3d>& positions) {
  std::vector<Vector2d> flat;
  flat.reserve(positions.size());
  for (const Vector3d& p : positions) flat.push_back(fibre.plane * p);
  const std::vector<std::size_t> corners = HullCorners(flat);
  std::vector<HullSide> sides;
  for (std::size_t n = 0; n < corners.size(); ++n) {
    HullSide side{corners[n], corners[(n + 1) % corners.size()], {}, 0.0};
    const Vector2d way = flat[side.to] - flat[side.from];
    side.length = way.norm();
    if (!(side.length > 0.0)) continue;
    side.along = way / side.length;
    sides.push_back(side);
  }
  return sides;
}

}  // namespace

FibreState Stretch(const BandFibre& fibre, const std::vector<Vector3d>& positions) {
  FibreState state;
  state.sides = SidesOf(fibre, positions);
  state.gradient.assign(positions.size(), Vector3d::Zero());
  for (const HullSide& side : state.sides) {
    state.length += fibre.length_factor * side.length;
    const Vector3d pull = fibre.length_factor * (fibre.plane.transpose() * side.along);
    state.gradient[side.to] += pull;
    state.gradient[side.from] -= pull;
  }
  const double longer = std::max(0.0, state.length - fibre.rest_length);
  state.tension = fibre.stiffness * longer / fibre.rest_length;
  state.energy = 0.5 * state.tension * longer;
  return state;
}

double HullLength(const BandFibre& fibre, const std::vector<Vector3d>& positions) {
  double length = 0.0;
  for (const HullSide& side : SidesOf(fibre, positions)) length += fibre.length_factor * side.length;
  return length;
}

}  // namespace annulus
