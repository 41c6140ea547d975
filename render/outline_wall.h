#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "modeling/glasses/lens_outline.h"

namespace annulus {

/// The wall over a lens' outline, seen along it: points and rays in the plane of the outline. Answers from a table by
/// angle about the box centre, about which an outline is star-shaped. Immutable.
class OutlineWall {
 public:
  /// Requires a valid outline.
  explicit OutlineWall(const LensOutline& outline);

  [[nodiscard]] const Eigen::Vector2d& centre() const { return centre_; }  ///< Of the box, mm.
  [[nodiscard]] double outer_radius() const { return outer_radius_; }      ///< About the centre, mm.
  [[nodiscard]] bool Inside(const Eigen::Vector2d& point) const;           ///< The outline itself counts.

  struct Stretch {
    double from;
    double to;
  };
  struct Crossing {
    double t;
    std::size_t side;
  };
  /// All crossings of origin + t·direction with the outline for t in `stretch`, in any order of t.
  template <typename Visit>
  void ForEachCrossing(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction, const Stretch& stretch,
                       const Visit& visit) const;

  /// Unit outward normals at a point of a side: the straight side's own, and smoothed over corners below 25°.
  [[nodiscard]] const Eigen::Vector2d& FlatNormal(std::size_t side) const { return sides_[side].normal; }
  [[nodiscard]] Eigen::Vector2d SmoothNormal(std::size_t side, const Eigen::Vector2d& point) const;

 private:
  static constexpr double kCentral = 1e-9;  // mm

  /// From one point of the outline to the next, about the centre.
  struct Side {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    Eigen::Vector2d normal;
    Eigen::Vector2d from_normal;
    Eigen::Vector2d to_normal;
  };
  [[nodiscard]] std::size_t SideTowards(const Eigen::Vector2d& about_centre) const;
  [[nodiscard]] bool IsWithin(std::size_t side, const Eigen::Vector2d& about_centre) const {
    return sides_[side].normal.dot(about_centre - sides_[side].from) <= 0.0;
  }
  [[nodiscard]] std::size_t After(std::size_t side) const { return side + 1 == sides_.size() ? 0 : side + 1; }
  [[nodiscard]] std::size_t Before(std::size_t side) const { return side == 0 ? sides_.size() - 1 : side - 1; }

  std::vector<Side> sides_;              // counter-clockwise
  std::vector<std::size_t> first_side_;  // by pseudo-angle: the side met towards the start of its step
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double inner_radius_ = 0.0;
  double outer_radius_ = 0.0;
  bool is_convex_ = true;
};

template <typename Visit>
void OutlineWall::ForEachCrossing(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                                  const Stretch& stretch, const Visit& visit) const {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  const Eigen::Vector2d o = origin - centre_;
  const Eigen::Vector2d a = o + stretch.from * direction;
  const Eigen::Vector2d b = o + stretch.to * direction;
  const double inner2 = inner_radius_ * inner_radius_;
  if (a.squaredNorm() < inner2 && b.squaredNorm() < inner2) return;
  const std::size_t side_a = SideTowards(a);
  const std::size_t side_b = SideTowards(b);
  if (is_convex_ && IsWithin(side_a, a) && IsWithin(side_b, b)) return;
  // Seen from the centre the ray turns one way only: the sides towards it are all that it can cross, with one more at
  // each end for what rounding does. A ray through the centre itself turns neither way: all sides.
  const double turning = cross(a, direction);
  const bool turns_left = turning > 0.0;
  const std::size_t first = turns_left ? side_a : side_b;
  const std::size_t last = turns_left ? side_b : side_a;
  const std::size_t count = sides_.size();
  const bool is_central = turning * turning < kCentral * kCentral * direction.squaredNorm();
  const std::size_t visits = is_central ? count : std::min(count, (last + count - first) % count + 3);
  std::size_t side = Before(first);
  for (std::size_t visited = 0; visited < visits; ++visited, side = After(side)) {
    const double from = cross(direction, sides_[side].from - o);
    const double to = cross(direction, sides_[side].to - o);
    if ((from < 0.0) == (to < 0.0)) continue;
    const Eigen::Vector2d meets = sides_[side].from + from / (from - to) * (sides_[side].to - sides_[side].from) - o;
    const double t = meets.dot(direction) / direction.squaredNorm();
    if (t >= stretch.from && t <= stretch.to) visit(Crossing{t, side});
  }
}

}  // namespace annulus
