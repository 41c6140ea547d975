#include "modeling/measure/surface_routes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "base/frames.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

constexpr double kNodes = 6000.0;
constexpr double kFarRoute = 1.1;  ///< Routes longer than this times the shortest are left out.
constexpr int kLocal = 3;          ///< A route's meeting node is the best within so many columns and rows.
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

using Polyline = std::vector<Eigen::Vector3d>;

double LengthOf(const Polyline& line) {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < line.size(); ++k) length += (line[k + 1] - line[k]).norm();
  return length;
}

/// The straight line in (theta, z) over a turn of `turn`, rad.
Polyline StraightLine(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to, double turn) {
  constexpr std::size_t kSteps = 64;
  Polyline line;
  for (std::size_t k = 0; k <= kSteps; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(kSteps);
    line.push_back(surface.Point(from.theta + t * turn, from.z + t * (to.z - from.z)));
  }
  return line;
}

/// Points of a row moved out to the row's convex hull, each along its own direction.
Polyline HullOfRow(const Polyline& row) {
  std::vector<Eigen::Vector2d> flat;
  for (const Eigen::Vector3d& point : row) flat.emplace_back(point.head<2>());
  const std::vector<Eigen::Vector2d> corners = ConvexHull(flat);
  if (corners.size() < 3) return row;
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  Polyline hull = row;
  for (std::size_t k = 0; k < row.size(); ++k) {
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Eigen::Vector2d& a = corners[c];
      const Eigen::Vector2d& b = corners[(c + 1) % corners.size()];
      if (cross(a, flat[k]) < 0.0 || cross(flat[k], b) < 0.0) continue;  // not in the sector of this edge
      const double against = cross(flat[k], b - a);
      if (against <= 0.0) continue;
      const double factor = cross(a, b - a) / against;
      if (factor > 1.0) hull[k].head<2>() *= factor;
    }
  }
  return hull;
}

/// A grid over all directions and the heights that a path of length `longest` can reach.
class RouteGrid {
 public:
  RouteGrid(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to, double longest,
            RouteSkin skin);

  [[nodiscard]] double cell() const { return cell_; }
  [[nodiscard]] std::size_t NodeAt(const SurfacePlace& place) const;
  /// Lengths of the shortest ways from `start`; `Promising(node, length)` says whether a node is worth going on from.
  struct Tree {
    std::vector<double> length;
    std::vector<std::size_t> parent;
  };
  template <class Promising>
  [[nodiscard]] Tree Ways(std::size_t start, const Promising& promising) const;
  /// Whether no node around has a smaller sum.
  [[nodiscard]] bool IsLocalMinimum(std::size_t node, const std::vector<double>& sum) const;
  [[nodiscard]] const Polyline& points() const { return points_; }

 private:
  [[nodiscard]] std::size_t Neighbour(std::size_t node, int columns, int rows) const;

  double cell_ = 1.0;  ///< mm
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  double z_low_ = 0.0;
  double z_step_ = 0.0;
  Polyline points_;  ///< Row by row.
};

RouteGrid::RouteGrid(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to, double longest,
                     RouteSkin skin) {
  const double middle = 0.5 * (from.z + to.z);
  z_low_ = std::max(surface.z_min(), middle - 0.5 * longest);
  const double z_high = std::min(surface.z_max(), middle + 0.5 * longest);
  constexpr int kProbes = 12;
  double radius = 0.0;
  for (int k = 0; k < kProbes; ++k) {
    const double theta = kTwoPi * k / kProbes;
    radius += (std::abs(surface.Radius(theta, from.z)) + std::abs(surface.Radius(theta, to.z))) / (2.0 * kProbes);
  }
  const double around = kTwoPi * std::max(radius, 1.0);
  cell_ = std::sqrt(around * (z_high - z_low_) / kNodes);
  columns_ = static_cast<std::size_t>(std::clamp(std::round(around / cell_), 24.0, 240.0));
  rows_ = static_cast<std::size_t>(std::clamp(std::round((z_high - z_low_) / cell_), 1.0, 240.0)) + 1;
  z_step_ = (z_high - z_low_) / static_cast<double>(rows_ - 1);
  cell_ = std::max(z_step_, around / static_cast<double>(columns_));
  for (std::size_t row = 0; row < rows_; ++row) {
    Polyline points;
    for (std::size_t column = 0; column < columns_; ++column) {
      points.push_back(surface.Point(kTwoPi * static_cast<double>(column) / static_cast<double>(columns_),
                                     z_low_ + z_step_ * static_cast<double>(row)));
    }
    if (skin == RouteSkin::kRowsHulls) points = HullOfRow(points);
    points_.insert(points_.end(), points.begin(), points.end());
  }
}

std::size_t RouteGrid::NodeAt(const SurfacePlace& place) const {
  const double column = std::round(WrapAngle(place.theta) / kTwoPi * static_cast<double>(columns_));
  const double row = z_step_ > 0.0 ? std::round((place.z - z_low_) / z_step_) : 0.0;
  return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows_ - 1))) * columns_ +
         static_cast<std::size_t>(column) % columns_;
}

std::size_t RouteGrid::Neighbour(std::size_t node, int columns, int rows) const {
  const auto row = static_cast<std::ptrdiff_t>(node / columns_) + rows;
  if (row < 0 || row >= static_cast<std::ptrdiff_t>(rows_)) return kNone;
  const auto width = static_cast<std::ptrdiff_t>(columns_);
  const auto column = (static_cast<std::ptrdiff_t>(node % columns_) + columns + width) % width;
  return static_cast<std::size_t>(row * width + column);
}

template <class Promising>
RouteGrid::Tree RouteGrid::Ways(std::size_t start, const Promising& promising) const {
  constexpr std::array<std::pair<int, int>, 16> kSteps{{{1, 0},
                                                        {-1, 0},
                                                        {0, 1},
                                                        {0, -1},
                                                        {1, 1},
                                                        {1, -1},
                                                        {-1, 1},
                                                        {-1, -1},
                                                        {2, 1},
                                                        {2, -1},
                                                        {-2, 1},
                                                        {-2, -1},
                                                        {1, 2},
                                                        {1, -2},
                                                        {-1, 2},
                                                        {-1, -2}}};
  Tree tree{std::vector<double>(points_.size(), kNever), std::vector<std::size_t>(points_.size(), kNone)};
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  tree.length[start] = 0.0;
  open.emplace(0.0, start);
  while (!open.empty()) {
    const auto [length, node] = open.top();
    open.pop();
    if (length > tree.length[node]) continue;
    for (const auto& [columns, rows] : kSteps) {
      const std::size_t next = Neighbour(node, columns, rows);
      if (next == kNone) continue;
      const double way = length + (points_[next] - points_[node]).norm();
      if (way >= tree.length[next] || !promising(next, way)) continue;
      tree.length[next] = way;
      tree.parent[next] = node;
      open.emplace(way, next);
    }
  }
  return tree;
}

bool RouteGrid::IsLocalMinimum(std::size_t node, const std::vector<double>& sum) const {
  for (int rows = -kLocal; rows <= kLocal; ++rows) {
    for (int columns = -kLocal; columns <= kLocal; ++columns) {
      const std::size_t other = Neighbour(node, columns, rows);
      if (other == kNone || other == node) continue;
      if (sum[other] < sum[node] || (sum[other] == sum[node] && other < node)) return false;
    }
  }
  return true;
}

/// Where the fronts of both trees meet (the first node of a way that is nearer to its end than to its start): the sum
/// of both lengths there, `kNever` elsewhere.
std::vector<double> MeetingSums(const RouteGrid::Tree& there, const RouteGrid::Tree& back) {
  std::vector<double> sums(there.length.size(), kNever);
  for (std::size_t node = 0; node < sums.size(); ++node) {
    if (back.length[node] == kNever || there.length[node] < back.length[node]) continue;
    const std::size_t parent = there.parent[node];
    if (parent != kNone && there.length[parent] >= back.length[parent]) continue;
    sums[node] = there.length[node] + back.length[node];
  }
  return sums;
}

/// The way through a meeting node, from end to end.
Polyline WayThrough(const RouteGrid& grid, const RouteGrid::Tree& there, const RouteGrid::Tree& back,
                    std::size_t meeting) {
  Polyline way;
  for (std::size_t node = meeting; node != kNone; node = there.parent[node]) way.push_back(grid.points()[node]);
  std::reverse(way.begin(), way.end());
  for (std::size_t node = back.parent[meeting]; node != kNone; node = back.parent[node]) {
    way.push_back(grid.points()[node]);
  }
  return way;
}

}  // namespace

std::vector<Polyline> ShortRoutes(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to,
                                  RouteSkin skin) {
  const double turn = AngleDifference(to.theta, from.theta);
  const Polyline straight = StraightLine(surface, from, to, turn);
  const Polyline other = StraightLine(surface, from, to, turn > 0.0 ? turn - kTwoPi : turn + kTwoPi);
  const double longest = std::min(LengthOf(straight), LengthOf(other));
  const Eigen::Vector3d& start = straight.front();
  const Eigen::Vector3d& end = straight.back();
  const RouteGrid grid(surface, from, to, 1.2 * longest, skin);
  const std::size_t first = grid.NodeAt(from);
  const std::size_t last = grid.NodeAt(to);
  if ((end - start).norm() < 4.0 * grid.cell() && longest < 8.0 * grid.cell()) return {straight};

  const double bound = 1.2 * longest + 4.0 * grid.cell();
  const RouteGrid::Tree there = grid.Ways(first, [&](std::size_t node, double way) {
    return way + (grid.points()[node] - grid.points()[last]).norm() <= bound;
  });
  const double shortest = there.length[last];
  if (shortest == kNever) return {straight};
  const RouteGrid::Tree back =
      grid.Ways(last, [&](std::size_t node, double way) { return way + there.length[node] <= kFarRoute * shortest; });
  const std::vector<double> sums = MeetingSums(there, back);
  std::vector<std::pair<double, std::size_t>> meetings;
  for (std::size_t node = 0; node < sums.size(); ++node) {
    if (sums[node] < kNever && grid.IsLocalMinimum(node, sums)) meetings.emplace_back(sums[node], node);
  }
  std::sort(meetings.begin(), meetings.end());
  if (meetings.size() > kMostRoutes) meetings.resize(kMostRoutes);
  std::vector<Polyline> routes;
  for (const auto& [sum, node] : meetings) {
    Polyline way = WayThrough(grid, there, back, node);
    way.front() = start;
    way.back() = end;
    routes.push_back(std::move(way));
  }
  if (routes.empty()) routes.push_back(straight);
  return routes;
}

}  // namespace annulus
