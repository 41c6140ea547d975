#include "modeling/flatten/plane_mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kDeepestFlips = 200;
/// Relative to the lengths in question: nearer to a line than this is on it.
constexpr double kOnLine = 1e-12;

double Cross(const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

/// Whether d lies inside the circle through the corners a, b, c of a counter-clockwise triangle.
bool InCircle(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const Vector2d u = a - d;
  const Vector2d v = b - d;
  const Vector2d w = c - d;
  const double value = u.squaredNorm() * Cross(v, w) + v.squaredNorm() * Cross(w, u) + w.squaredNorm() * Cross(u, v);
  const double scale = u.squaredNorm() * v.squaredNorm() + w.squaredNorm() * w.squaredNorm();
  return value > 1e-13 * scale;
}

}  // namespace

double PlaneMesh::Turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return Cross(points_[b] - points_[a], points_[c] - points_[a]);
}

std::size_t PlaneMesh::SideTo(std::uint32_t t, std::uint32_t u) const {
  const auto& across = triangles_[t].across;
  return static_cast<std::size_t>(std::find(across.begin(), across.end(), u) - across.begin());
}

/// Makes `u` the neighbour of t beyond a side, and t the neighbour of u beyond the same one.
void PlaneMesh::Join(std::uint32_t t, std::size_t side, std::uint32_t u) {
  triangles_[t].across[side] = u;
  if (u == kNone) return;
  const std::uint32_t from = triangles_[t].vertex[(side + 1) % 3];
  for (std::size_t k = 0; k < 3; ++k) {
    if (triangles_[u].vertex[k] == from && triangles_[u].vertex[(k + 1) % 3] == triangles_[t].vertex[side]) {
      triangles_[u].across[k] = t;
    }
  }
}

/// Exchanges the diagonal ab of the quadrangle a, d, b, c for dc; t becomes (c, a, d), its neighbour (d, b, c).
void PlaneMesh::Flip(std::uint32_t t, std::size_t side) {
  const Triangle old = triangles_[t];
  const std::uint32_t u = old.across[side];
  const Triangle other = triangles_[u];
  const std::size_t back = SideTo(u, t);
  const std::size_t next = (side + 1) % 3;
  const std::size_t last = (side + 2) % 3;
  const std::size_t other_next = (back + 1) % 3;
  const std::size_t other_last = (back + 2) % 3;
  const std::uint32_t a = old.vertex[side];
  const std::uint32_t b = old.vertex[next];
  const std::uint32_t c = old.vertex[last];
  const std::uint32_t d = other.vertex[other_last];
  triangles_[t] = {{c, a, d}, {kNone, kNone, u}, {old.fixed[last], other.fixed[other_next], false}};
  triangles_[u] = {{d, b, c}, {kNone, kNone, t}, {other.fixed[other_last], old.fixed[next], false}};
  Join(t, 0, old.across[last]);
  Join(t, 1, other.across[other_next]);
  Join(u, 0, other.across[other_last]);
  Join(u, 1, old.across[next]);
}

void PlaneMesh::SplitTriangle(std::uint32_t t, std::uint32_t p) {
  const Triangle old = triangles_[t];
  const auto [a, b, c] = old.vertex;
  const auto first = static_cast<std::uint32_t>(triangles_.size());
  triangles_[t] = {{a, b, p}, {kNone, first, first + 1}, {old.fixed[0], false, false}};
  triangles_.push_back({{b, c, p}, {kNone, first + 1, t}, {old.fixed[1], false, false}});
  triangles_.push_back({{c, a, p}, {kNone, t, first}, {old.fixed[2], false, false}});
  Join(t, 0, old.across[0]);
  Join(first, 0, old.across[1]);
  Join(first + 1, 0, old.across[2]);
}

void PlaneMesh::SplitSide(std::uint32_t t, std::size_t side, std::uint32_t p) {
  const Triangle old = triangles_[t];
  const std::size_t next = (side + 1) % 3;
  const std::size_t last = (side + 2) % 3;
  const std::uint32_t a = old.vertex[side];
  const std::uint32_t b = old.vertex[next];
  const std::uint32_t c = old.vertex[last];
  const bool fixed = old.fixed[side];
  const std::uint32_t u = old.across[side];
  const std::size_t back = u == kNone ? 0 : SideTo(u, t);
  const auto first = static_cast<std::uint32_t>(triangles_.size());
  triangles_[t] = {{a, p, c}, {kNone, first, kNone}, {fixed, false, old.fixed[last]}};
  triangles_.push_back({{p, b, c}, {kNone, kNone, t}, {fixed, old.fixed[next], false}});
  Join(t, 2, old.across[last]);
  Join(first, 1, old.across[next]);
  if (u == kNone) return;
  const Triangle other = triangles_[u];
  const std::size_t other_next = (back + 1) % 3;
  const std::size_t other_last = (back + 2) % 3;
  const std::uint32_t d = other.vertex[other_last];
  const std::uint32_t second = first + 1;
  triangles_[u] = {{p, a, d}, {t, kNone, second}, {fixed, other.fixed[other_next], false}};
  triangles_.push_back({{b, p, d}, {first, u, kNone}, {fixed, false, other.fixed[other_last]}});
  triangles_[t].across[0] = u;
  triangles_[first].across[0] = second;
  Join(u, 1, other.across[other_next]);
  Join(second, 2, other.across[other_last]);
}

bool PlaneMesh::IsConvexAcross(std::uint32_t t, std::size_t side) const {
  const Triangle& triangle = triangles_[t];
  const std::uint32_t u = triangle.across[side];
  const std::uint32_t a = triangle.vertex[side];
  const std::uint32_t b = triangle.vertex[(side + 1) % 3];
  const std::uint32_t c = triangle.vertex[(side + 2) % 3];
  const std::uint32_t d = triangles_[u].vertex[(SideTo(u, t) + 2) % 3];
  const double scale = (points_[c] - points_[d]).squaredNorm() + (points_[a] - points_[b]).squaredNorm();
  return Turn(c, a, d) > kOnLine * scale && Turn(d, b, c) > kOnLine * scale;
}

bool PlaneMesh::ShouldFlip(std::uint32_t t, std::size_t side) const {
  const Triangle& triangle = triangles_[t];
  const std::uint32_t u = triangle.across[side];
  if (u == kNone || triangle.fixed[side] || !IsConvexAcross(t, side)) return false;
  const std::uint32_t a = triangle.vertex[side];
  const std::uint32_t b = triangle.vertex[(side + 1) % 3];
  const std::uint32_t c = triangle.vertex[(side + 2) % 3];
  const std::uint32_t d = triangles_[u].vertex[(SideTo(u, t) + 2) % 3];
  if (lifted_.empty()) return InCircle(points_[a], points_[b], points_[c], points_[d]);
  // On the surface: the angles at c and d make more than half a turn, so that their cotangents' sum is negative.
  const auto cotangent = [this](std::uint32_t apex, std::uint32_t p, std::uint32_t q) {
    const Vector3d v = lifted_[p] - lifted_[apex];
    const Vector3d w = lifted_[q] - lifted_[apex];
    return v.dot(w) / std::max(v.cross(w).norm(), 1e-300);
  };
  return cotangent(c, a, b) + cotangent(d, a, b) < -1e-9;
}

/// Flips a side that is not Delaunay, then those of the quadrangle that face away from the side's apex.
void PlaneMesh::Legalise(std::uint32_t t, std::size_t side, int depth) {
  if (depth > kDeepestFlips || !ShouldFlip(t, side)) return;
  const std::uint32_t u = triangles_[t].across[side];
  Flip(t, side);
  Legalise(t, 1, depth + 1);
  Legalise(u, 0, depth + 1);
}

void PlaneMesh::BeginAround(const std::vector<Vector2d>& points) {
  Eigen::Array2d low = points.front();
  Eigen::Array2d high = points.front();
  for (const Vector2d& p : points) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  const Vector2d middle = (0.5 * (low + high)).matrix();
  const double reach = 20.0 * (high - low).maxCoeff();
  points_ = points;
  points_.emplace_back(middle + reach * Vector2d(-0.87, -0.5));
  points_.emplace_back(middle + reach * Vector2d(0.87, -0.5));
  points_.emplace_back(middle + reach * Vector2d(0.0, 1.0));
  const auto first = static_cast<std::uint32_t>(points.size());
  triangles_ = {{{first, first + 1, first + 2}}};
}

/// The triangle that holds a point: a walk towards it.
std::uint32_t PlaneMesh::Locate(const Vector2d& p) {
  std::uint32_t t = last_;
  for (std::size_t step = 0; step < 4 * triangles_.size() + 16; ++step) {
    std::uint32_t next = kNone;
    for (std::size_t j = 0; j < 3 && next == kNone; ++j) {
      const std::size_t k = (j + step) % 3;  // another side first each time, or the walk might go in circles
      const Vector2d& a = points_[triangles_[t].vertex[k]];
      const Vector2d& b = points_[triangles_[t].vertex[(k + 1) % 3]];
      if (Cross(b - a, p - a) < -kOnLine * (b - a).squaredNorm()) next = triangles_[t].across[k];
    }
    if (next == kNone) return last_ = t;
    t = next;
  }
  return kNone;
}

bool PlaneMesh::Insert(std::uint32_t vertex) {
  const Vector2d p = points_[vertex];
  const std::uint32_t t = Locate(p);
  if (t == kNone) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2d& a = points_[triangles_[t].vertex[k]];
    const Vector2d& b = points_[triangles_[t].vertex[(k + 1) % 3]];
    const double length = (b - a).squaredNorm();
    if ((p - a).squaredNorm() <= 1e-20 * length) return false;
    if (std::abs(Cross(b - a, p - a)) > kOnLine * length) continue;
    const std::uint32_t u = triangles_[t].across[k];
    const auto first = static_cast<std::uint32_t>(triangles_.size());
    SplitSide(t, k, vertex);
    Legalise(t, 2, 0);
    Legalise(first, 1, 0);
    if (u != kNone) {
      Legalise(u, 1, 0);
      Legalise(first + 1, 2, 0);
    }
    return true;
  }
  const auto first = static_cast<std::uint32_t>(triangles_.size());
  SplitTriangle(t, vertex);
  Legalise(t, 0, 0);
  Legalise(first, 0, 0);
  Legalise(first + 1, 0, 0);
  return true;
}

PlaneMesh::Corner PlaneMesh::FindSide(std::uint32_t from, std::uint32_t to) const {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (triangles_[t].vertex[k] == from && triangles_[t].vertex[(k + 1) % 3] == to) {
        return {static_cast<std::uint32_t>(t), static_cast<std::uint8_t>(k)};
      }
    }
  }
  return {};
}

/// Flips sides that cross the line until it is a side itself (Sloan).
bool PlaneMesh::FlipAwayCrossing(std::uint32_t from, std::uint32_t to) {
  const auto crosses = [&](std::uint32_t a, std::uint32_t b) {
    if (a == from || a == to || b == from || b == to) return false;
    return Turn(from, to, a) * Turn(from, to, b) < 0.0 && Turn(a, b, from) * Turn(a, b, to) < 0.0;
  };
  std::deque<std::array<std::uint32_t, 2>> crossing;
  for (const Triangle& triangle : triangles_) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle.vertex[k];
      const std::uint32_t b = triangle.vertex[(k + 1) % 3];
      if (a < b && crosses(a, b)) {
        if (triangle.fixed[k]) return false;
        crossing.push_back({a, b});
      }
    }
  }
  for (std::size_t left = 50 * (crossing.size() + 4); !crossing.empty() && left > 0; --left) {
    const auto [a, b] = crossing.front();
    crossing.pop_front();
    const Corner corner = FindSide(a, b);
    if (corner.triangle == kNone) continue;
    if (!IsConvexAcross(corner.triangle, corner.side)) {
      crossing.push_back({a, b});
      continue;
    }
    Flip(corner.triangle, corner.side);
    const std::uint32_t c = triangles_[corner.triangle].vertex[0];
    const std::uint32_t d = triangles_[corner.triangle].vertex[2];
    if (crosses(c, d)) crossing.push_back({std::min(c, d), std::max(c, d)});
  }
  return crossing.empty();
}

bool PlaneMesh::FixLine(std::uint32_t from, std::uint32_t to) {
  if (FindSide(from, to).triangle == kNone && !FlipAwayCrossing(from, to)) return false;
  for (const auto& [a, b] : {std::pair(from, to), std::pair(to, from)}) {
    const Corner corner = FindSide(a, b);
    if (corner.triangle == kNone) return false;
    triangles_[corner.triangle].fixed[corner.side] = true;
  }
  return true;
}

/// Removes what can be reached from the triangle around all without crossing a given line, and its three corners.
void PlaneMesh::RemoveOutside(std::size_t given) {
  std::vector<bool> outside(triangles_.size(), false);
  std::vector<std::uint32_t> open;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& v = triangles_[t].vertex;
    if (std::max({v[0], v[1], v[2]}) < given) continue;
    outside[t] = true;
    open.push_back(static_cast<std::uint32_t>(t));
  }
  while (!open.empty()) {
    const Triangle& triangle = triangles_[open.back()];
    open.pop_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = triangle.across[k];
      if (u == kNone || triangle.fixed[k] || outside[u]) continue;
      outside[u] = true;
      open.push_back(u);
    }
  }
  std::vector<std::uint32_t> number(triangles_.size(), kNone);
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (outside[t]) continue;
    number[t] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(triangles_[t]);
  }
  for (Triangle& triangle : kept) {
    for (std::uint32_t& u : triangle.across) u = u == kNone ? kNone : number[u];
  }
  triangles_ = std::move(kept);
  points_.resize(given);
}

Result<PlaneMesh> PlaneMesh::Fill(const Lines& lines) {
  const auto& [points, rim_count, held_count, chains] = lines;
  const auto refuse = [](std::string seen) {
    return Fail("fill the region with triangles", std::move(seen),
                "let the outline's lines meet at their ends only, and keep darts and grain line inside");
  };
  PlaneMesh mesh;
  mesh.given_ = held_count;
  mesh.BeginAround(points);
  const auto insert = [&mesh](std::size_t k) { return mesh.Insert(static_cast<std::uint32_t>(k)); };
  for (std::size_t k = 0; k < held_count; ++k) {
    if (!insert(k)) return refuse(fmt::format("point {} lies on another", k));
  }
  for (std::size_t k = 0; k < rim_count; ++k) {
    if (!mesh.FixLine(static_cast<std::uint32_t>(k), static_cast<std::uint32_t>((k + 1) % rim_count))) {
      return refuse(fmt::format("the outline crosses itself or a point of it near its point {} of {}", k, rim_count));
    }
  }
  for (const Chain& chain : chains) {
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      if (!mesh.FixLine(chain[k], chain[k + 1])) return refuse("a line inside crosses the outline or another line");
    }
  }
  for (std::size_t k = held_count; k < points.size(); ++k) {
    if (!insert(k)) return refuse(fmt::format("point {} lies on another", k));
  }
  mesh.RemoveOutside(points.size());
  std::vector<bool> used(points.size(), false);
  for (const Triangle& triangle : mesh.triangles_) {
    for (const std::uint32_t v : triangle.vertex) used[v] = true;
  }
  const auto missing = std::find(used.begin(), used.end(), false);
  if (missing != used.end()) return refuse(fmt::format("point {} lies outside the outline", missing - used.begin()));
  return mesh;
}

/// Cuts every side that is too long and whose triangles have not been touched in this round; returns how many are too
/// long.
std::size_t PlaneMesh::SplitLong(double longest) {
  struct Long {
    double length;
    std::uint32_t a, b, t;
  };
  std::vector<Long> sides;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle.vertex[k];
      const std::uint32_t b = triangle.vertex[(k + 1) % 3];
      const double length = (lifted_[b] - lifted_[a]).norm();
      if (triangle.fixed[k] || a > b || length <= longest) continue;
      sides.push_back({length, a, b, static_cast<std::uint32_t>(t)});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Long& x, const Long& y) {
    return x.length != y.length ? x.length > y.length : std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  for (const Long& side : sides) {
    // A triangle that was cut or flipped meanwhile no longer has the side: its turn comes in the next round.
    for (std::size_t k = 0; k < 3; ++k) {
      if (triangles_[side.t].vertex[k] != side.a || triangles_[side.t].vertex[(k + 1) % 3] != side.b) continue;
      const std::uint32_t u = triangles_[side.t].across[k];
      const auto vertex = static_cast<std::uint32_t>(points_.size());
      const auto first = static_cast<std::uint32_t>(triangles_.size());
      points_.emplace_back(0.5 * (points_[side.a] + points_[side.b]));
      lifted_.push_back(lift_(points_.back()));
      SplitSide(side.t, k, vertex);
      Legalise(side.t, 2, 0);
      Legalise(first, 1, 0);
      if (u != kNone) {
        Legalise(u, 1, 0);
        Legalise(first + 1, 2, 0);
      }
      break;
    }
  }
  return sides.size();
}

void PlaneMesh::FlipAll() {
  for (int round = 0; round < 10; ++round) {
    bool changed = false;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (!ShouldFlip(t, k)) continue;
        Flip(t, k);
        changed = true;
      }
    }
    if (!changed) return;
  }
}

/// Moves each free vertex to the middle of the triangles around it, weighted by their area on the surface, where none
/// of them turns over.
void PlaneMesh::Even() {
  std::vector<std::vector<std::uint32_t>> around(points_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const std::uint32_t v : triangles_[t].vertex) around[v].push_back(static_cast<std::uint32_t>(t));
  }
  for (std::size_t v = given_; v < points_.size(); ++v) {
    Vector2d sum = Vector2d::Zero();
    double weight = 0.0;
    for (const std::uint32_t t : around[v]) {
      const auto& [a, b, c] = triangles_[t].vertex;
      const double area = (lifted_[b] - lifted_[a]).cross(lifted_[c] - lifted_[a]).norm();
      sum += area / 3.0 * (points_[a] + points_[b] + points_[c]);
      weight += area;
    }
    if (!(weight > 0.0)) continue;
    const Vector2d before = points_[v];
    points_[v] = sum / weight;
    bool good = true;
    for (const std::uint32_t t : around[v]) {
      const auto& [a, b, c] = triangles_[t].vertex;
      const double scale = (points_[b] - points_[a]).squaredNorm() + (points_[c] - points_[a]).squaredNorm();
      good = good && Turn(a, b, c) > 1e-3 * scale;
    }
    if (good) {
      lifted_[v] = lift_(points_[v]);
    } else {
      points_[v] = before;
    }
  }
}

Status PlaneMesh::Refine(const Lift& lift, double longest, std::size_t most) {
  lift_ = lift;
  lifted_.clear();
  for (const Vector2d& p : points_) lifted_.push_back(lift(p));
  FlipAll();
  constexpr int kRounds = 60;
  for (int round = 0; round < kRounds && SplitLong(longest) > 0; ++round) {
    if (triangles_.size() > most) {
      return Fail("fill the region with triangles", fmt::format("over {} would be needed", most),
                  "take larger elements or a smaller region");
    }
  }
  for (int round = 0; round < 3; ++round) {
    Even();
    FlipAll();
  }
  for (int round = 0; round < kRounds && SplitLong(longest) > 0; ++round) {
  }
  return {};
}

}  // namespace annulus
