#include "render/outline_wall.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr std::size_t kAngleSteps = 512;
/// Cosine of the 25° up to which neighbouring sides are one smooth curve.
constexpr double kSmooth = 0.906308;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Rises with the angle from 0 to 4 over a full turn.
double PseudoAngle(const Eigen::Vector2d& p) {
  const double sum = std::abs(p.x()) + std::abs(p.y());
  if (sum == 0.0) return 0.0;
  const double share = p.y() / sum;
  if (p.x() >= 0.0) return p.y() >= 0.0 ? share : 4.0 + share;
  return 2.0 - share;
}

/// The direction of a pseudo-angle.
Eigen::Vector2d Towards(double pseudo_angle) {
  const double p = std::fmod(pseudo_angle, 4.0);
  if (p < 1.0) return {1.0 - p, p};
  if (p < 2.0) return {1.0 - p, 2.0 - p};
  if (p < 3.0) return {p - 3.0, 2.0 - p};
  return {p - 3.0, p - 4.0};
}

/// Distance of the origin from the stretch a … b.
double DistanceToSide(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double share = std::clamp(-a.dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (a + share * along).norm();
}

}  // namespace

OutlineWall::OutlineWall(const LensOutline& outline) : centre_(BoxOf(outline).centre) {
  const std::size_t count = outline.points.size();
  inner_radius_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d from = outline.points[i] - centre_;
    const Eigen::Vector2d to = outline.points[i + 1 == count ? 0 : i + 1] - centre_;
    const Eigen::Vector2d normal = Eigen::Vector2d(to.y() - from.y(), from.x() - to.x()).normalized();
    sides_.push_back({from, to, normal, normal, normal});
    inner_radius_ = std::min(inner_radius_, DistanceToSide(from, to));
    outer_radius_ = std::max(outer_radius_, from.norm());
  }
  for (std::size_t i = 0; i < count; ++i) {
    Side& next = sides_[After(i)];
    is_convex_ = is_convex_ && Cross(sides_[i].normal, next.normal) >= 0.0;
    if (sides_[i].normal.dot(next.normal) < kSmooth) continue;
    next.from_normal = (sides_[i].normal + next.normal).normalized();
    sides_[i].to_normal = next.from_normal;
  }
  const auto holds = [this](std::size_t side, const Eigen::Vector2d& p) {
    return Cross(sides_[side].from, p) >= 0.0 && Cross(p, sides_[side].to) > 0.0;
  };
  std::size_t side = 0;
  for (std::size_t step = 0; step < kAngleSteps; ++step) {
    const Eigen::Vector2d direction = Towards(4.0 * static_cast<double>(step) / kAngleSteps);
    for (std::size_t tried = 0; tried < count && !holds(side, direction); ++tried) side = After(side);
    first_side_.push_back(side);
  }
}

std::size_t OutlineWall::SideTowards(const Eigen::Vector2d& about_centre) const {
  const auto step = static_cast<std::size_t>(PseudoAngle(about_centre) * (kAngleSteps / 4.0));
  std::size_t side = first_side_[std::min(step, kAngleSteps - 1)];
  for (std::size_t tried = 0; tried < sides_.size() && Cross(sides_[side].to, about_centre) >= 0.0; ++tried) {
    side = After(side);
  }
  return side;
}

bool OutlineWall::Inside(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d p = point - centre_;
  const double squared = p.squaredNorm();
  if (squared < inner_radius_ * inner_radius_) return true;
  if (!(squared <= outer_radius_ * outer_radius_)) return false;
  return IsWithin(SideTowards(p), p);
}

Eigen::Vector2d OutlineWall::SmoothNormal(std::size_t side, const Eigen::Vector2d& point) const {
  const Side& s = sides_[side];
  const Eigen::Vector2d along = s.to - s.from;
  const double share = std::clamp((point - centre_ - s.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return ((1.0 - share) * s.from_normal + share * s.to_normal).normalized();
}

}  // namespace annulus
