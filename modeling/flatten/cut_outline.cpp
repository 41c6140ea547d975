#include "modeling/flatten/cut_outline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/ensure.h"
#include "modeling/flatten/surface_region.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Outline = std::vector<Vector2d>;

constexpr double kMitreLimit = 2.5;
constexpr int kMostLoops = 200;

double Cross(const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

/// Unit normal that points out of a counter-clockwise outline.
Vector2d Outwards(const Vector2d& from, const Vector2d& to) {
  const Vector2d along = (to - from).normalized();
  return {along.y(), -along.x()};
}

/// The moved corner: where the two moved sides meet, or the two points of a bevel.
void AddCorner(const Vector2d& p, const Vector2d& before, const Vector2d& after, Outline& moved) {
  // q with q·b̂ = |b| and q·â = |a|, for normals b̂, â.
  const double b = before.norm();
  const double a = after.norm();
  const Vector2d u = b > 0.0 ? Vector2d(before / b) : Vector2d(0.0, 0.0);
  const Vector2d v = a > 0.0 ? Vector2d(after / a) : Vector2d(0.0, 0.0);
  const double turn = Cross(u, v);
  if (std::abs(turn) > 1e-3) {
    const Vector2d q = Vector2d(v.y() * b - u.y() * a, u.x() * a - v.x() * b) / turn;
    if (q.norm() <= kMitreLimit * std::max(a, b)) {
      moved.push_back(p + q);
      return;
    }
  } else if (u.dot(v) > 0.0 && std::abs(a - b) < 1e-9) {
    moved.push_back(p + before);
    return;
  }
  moved.push_back(p + before);
  moved.push_back(p + after);
}

struct Crossing {
  std::size_t one, other;
  Vector2d at;
};

std::optional<Crossing> FindCrossing(const Outline& outline) {
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& a = outline[i];
    const Vector2d r = outline[(i + 1) % n] - a;
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j + 1 == n) continue;
      const Vector2d& c = outline[j];
      const Vector2d s = outline[(j + 1) % n] - c;
      const double turn = Cross(r, s);
      if (turn == 0.0) continue;
      const double t = Cross(c - a, s) / turn;
      const double w = Cross(c - a, r) / turn;
      // A side owns its beginning only: a crossing at a corner is found once, a corner shared by neighbours never.
      if (t >= 0.0 && t < 1.0 && w >= 0.0 && w < 1.0) return Crossing{i, j, a + t * r};
    }
  }
  return {};
}

}  // namespace

std::vector<Vector2d> OffsetOutline(const Outline& outline, const std::vector<double>& distance) {
  ENSURE(outline.size() >= 3 && distance.size() == outline.size(), "an outline has a distance per side");
  const std::size_t n = outline.size();
  Outline moved;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t last = (k + n - 1) % n;
    AddCorner(outline[k], distance[last] * Outwards(outline[last], outline[k]),
              distance[k] * Outwards(outline[k], outline[(k + 1) % n]), moved);
  }
  for (int loop = 0; loop < kMostLoops; ++loop) {
    const auto crossing = FindCrossing(moved);
    if (!crossing) break;
    const auto first = moved.begin() + static_cast<std::ptrdiff_t>(crossing->one) + 1;
    const auto last = moved.begin() + static_cast<std::ptrdiff_t>(crossing->other) + 1;
    Outline inner(first, last);
    inner.push_back(crossing->at);
    Outline outer(moved.begin(), first);
    outer.push_back(crossing->at);
    outer.insert(outer.end(), last, moved.end());
    moved = TurnedArea(outer) >= TurnedArea(inner) ? std::move(outer) : std::move(inner);
  }
  return moved;
}

}  // namespace annulus
