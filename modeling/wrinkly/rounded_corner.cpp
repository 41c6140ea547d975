#include "modeling/wrinkly/rounded_corner.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Below 2^-40 of a patch the cell's points agree to rounding: there the limit's tangents are taken.
constexpr int kDeepest = 40;

/// The 3 × 3 control points around a regular patch, [column][row].
using Neighbourhood = std::array<std::array<Vector3d, 3>, 3>;

BiquadraticNet NetOf(const Neighbourhood& p) {
  const auto middle = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) -> Vector3d {
    return 0.25 * (p[a][b] + p[a][d] + p[c][b] + p[c][d]);
  };
  BiquadraticNet net;
  for (const std::size_t a : {std::size_t{0}, std::size_t{2}}) {
    for (const std::size_t b : {std::size_t{0}, std::size_t{2}}) net[a][b] = middle(a, b, 1, 1);
    net[a][1] = 0.5 * (p[a][1] + p[1][1]);
    net[1][a] = 0.5 * (p[1][a] + p[1][1]);
  }
  net[1][1] = p[1][1];
  return net;
}

/// Corner a of the regular cell a, b, c, d after a step; b and d are its neighbours.
Vector3d Step(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return 0.5625 * a + 0.1875 * (b + d) + 0.0625 * c;
}

/// A corner after a step, and what else the three regular quarters beside it need.
struct Subdivided {
  RoundedCorner corner;
  Vector3d x0_x, x0_xy, x1_x, y0_y, y0_xy, y1_y, xy_xy;
};

Subdivided Subdivide(const RoundedCorner& c) {
  const Vector3d& p = c.ring.front();
  const Vector3d& right = c.ring[1];
  const Vector3d& left = c.ring.back();
  Subdivided next;
  next.corner.ring.reserve(c.ring.size());
  for (std::size_t k = 0; k < c.ring.size(); ++k) next.corner.ring.push_back(DooSabinPoint(c.ring, k));
  next.corner.x0 = Step(p, right, c.x1, c.x0);
  next.corner.x1 = Step(right, p, c.x0, c.x1);
  next.corner.y0 = Step(p, left, c.y1, c.y0);
  next.corner.y1 = Step(left, p, c.y0, c.y1);
  next.corner.xy = Step(p, c.x0, c.xy, c.y0);
  next.x0_x = Step(c.x0, p, right, c.x1);
  next.x1_x = Step(c.x1, right, p, c.x0);
  next.y0_y = Step(c.y0, p, left, c.y1);
  next.y1_y = Step(c.y1, left, p, c.y0);
  next.x0_xy = Step(c.x0, p, c.y0, c.xy);
  next.y0_xy = Step(c.y0, p, c.x0, c.xy);
  next.xy_xy = Step(c.xy, c.x0, p, c.y0);
  return next;
}

/// A point of the three quarters beyond the middle, all regular; x and y count from 0 to 2, one of them over 1.
PatchPoint PointBeyond(const Subdivided& s, double x, double y) {
  const RoundedCorner& c = s.corner;
  const Vector3d& p = c.ring.front();
  if (x >= 1.0 && y >= 1.0) {
    return PointOn(NetOf({{{p, c.y0, s.y0_y}, {c.x0, c.xy, s.y0_xy}, {s.x0_x, s.x0_xy, s.xy_xy}}}), x - 1.0, y - 1.0);
  }
  if (x >= 1.0) {
    return PointOn(NetOf({{{c.ring[1], p, c.y0}, {c.x1, c.x0, c.xy}, {s.x1_x, s.x0_x, s.x0_xy}}}), x - 1.0, y);
  }
  return PointOn(NetOf({{{c.ring.back(), c.y1, s.y1_y}, {p, c.y0, s.y0_y}, {c.x0, c.xy, s.y0_xy}}}), x, y - 1.0);
}

PatchPoint Scaled(PatchPoint point, double scale) {
  point.du *= scale;
  point.dv *= scale;
  return point;
}

/// The limit in the middle of a cell: its centroid, and the tangents of Doo and Sabin's analysis (the first harmonics).
PatchPoint Limit(const RoundedCorner& c) {
  const auto n = static_cast<double>(c.ring.size());
  PatchPoint limit;
  Vector3d cosine = Vector3d::Zero();
  Vector3d sine = Vector3d::Zero();
  for (std::size_t k = 0; k < c.ring.size(); ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / n;
    limit.point += c.ring[k] / n;
    cosine += std::cos(angle) * c.ring[k];
    sine += std::sin(angle) * c.ring[k];
  }
  // The sides to ring[1] and ring.back() leave the middle at half a step before and after ring[0].
  const double half = std::numbers::pi / n;
  limit.du = std::cos(half) * cosine + std::sin(half) * sine;
  limit.dv = std::cos(half) * cosine - std::sin(half) * sine;
  return limit;
}

}  // namespace

PatchPoint PointOn(const BiquadraticNet& net, double u, double v) {
  const std::array<double, 3> b{(1.0 - v) * (1.0 - v), 2.0 * v * (1.0 - v), v * v};
  std::array<Vector3d, 3> row;
  std::array<Vector3d, 3> change;
  for (std::size_t a = 0; a < 3; ++a) {
    row[a] = b[0] * net[a][0] + b[1] * net[a][1] + b[2] * net[a][2];
    change[a] = 2.0 * ((1.0 - v) * (net[a][1] - net[a][0]) + v * (net[a][2] - net[a][1]));
  }
  const std::array<double, 3> w{(1.0 - u) * (1.0 - u), 2.0 * u * (1.0 - u), u * u};
  return {w[0] * row[0] + w[1] * row[1] + w[2] * row[2], 2.0 * ((1.0 - u) * (row[1] - row[0]) + u * (row[2] - row[1])),
          w[0] * change[0] + w[1] * change[1] + w[2] * change[2]};
}

Vector3d DooSabinPoint(const std::vector<Vector3d>& cell, std::size_t first) {
  const auto n = static_cast<double>(cell.size());
  Vector3d point = Vector3d::Zero();
  for (std::size_t j = 0; j < cell.size(); ++j) {
    const double harmonic = 3.0 + 2.0 * std::cos(2.0 * std::numbers::pi * static_cast<double>(j) / n);
    const double weight = (harmonic + (j == 0 ? n : 0.0)) / (4.0 * n);
    point += weight * cell[(first + j) % cell.size()];
  }
  return point;
}

PatchPoint RoundedCorner::At(double x, double y) const {
  if (ring.size() == 4) {
    return PointOn(NetOf({{{ring[2], ring[3], y1}, {ring[1], ring[0], y0}, {x1, x0, xy}}}), x, y);
  }
  RoundedCorner corner = *this;
  double scale = 1.0;
  for (int depth = 0; depth < kDeepest; ++depth) {
    Subdivided next = Subdivide(corner);
    x *= 2.0;
    y *= 2.0;
    scale *= 2.0;
    if (x >= 1.0 || y >= 1.0) return Scaled(PointBeyond(next, x, y), scale);
    if (x == 0.0 && y == 0.0) break;
    corner = std::move(next.corner);
  }
  return Limit(corner);
}

}  // namespace annulus
