#include "modeling/glasses/lens_outline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

constexpr std::size_t kFewestPoints = 90;
constexpr double kLargestCoordinate = 1e6;  // mm; no lens, but sums of squares stay exact enough

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

const Eigen::Vector2d& Next(const std::vector<Eigen::Vector2d>& points, std::size_t i) {
  return points[i + 1 == points.size() ? 0 : i + 1];
}

tl::unexpected<Error> Refuse(std::string seen) {
  return Fail(
      "use a lens outline", std::move(seen),
      "give at least 90 points in mm, counter-clockwise, of a shape that every ray from its middle leaves once");
}

Eigen::Vector2d BoxCentre(const std::vector<Eigen::Vector2d>& points) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& point : points) box.extend(point);
  return box.center();
}

/// The distance from `centre` at which a ray along `direction` crosses the side from a to b.
double RadiusAt(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& direction) {
  return Cross(a, b) / Cross(direction, b - a);
}

}  // namespace

Status Validate(const LensOutline& outline) {
  const auto& points = outline.points;
  if (points.size() < kFewestPoints) return Refuse(fmt::format("it has {} points, fewer than 90", points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(std::abs(points[i].x()) < kLargestCoordinate && std::abs(points[i].y()) < kLargestCoordinate)) {
      return Refuse(fmt::format("point {} is not a number in mm", i));
    }
  }
  const Eigen::Vector2d centre = BoxCentre(points);
  double turned = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d a = points[i] - centre;
    const Eigen::Vector2d b = Next(points, i) - centre;
    const double cross = Cross(a, b);
    if (!(cross > 0.0)) {
      return Refuse(fmt::format("from point {} on it does not turn counter-clockwise about its box centre", i));
    }
    turned += std::atan2(cross, a.dot(b));
  }
  // Every step turns by less than π forward, so the sum is a whole number of turns.
  if (turned > 1.5 * kTwoPi) return Refuse("it runs round its box centre more than once");
  return {};
}

LensBox BoxOf(const LensOutline& outline) {
  Eigen::AlignedBox2d box;
  LensBox result;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    box.extend(outline.points[i]);
    result.circumference += (Next(outline.points, i) - outline.points[i]).norm();
  }
  result.centre = box.center();
  result.a = box.sizes().x();
  result.b = box.sizes().y();
  for (const Eigen::Vector2d& point : outline.points)
    result.ed = std::max(result.ed, 2.0 * (point - result.centre).norm());
  return result;
}

std::vector<double> RadiiOf(const LensOutline& outline, std::size_t count) {
  const auto& points = outline.points;
  const Eigen::Vector2d centre = BoxCentre(points);
  // The side that the ray at angle 0 crosses; the others follow in order, because the outline is star-shaped.
  std::size_t side = 0;
  const auto crosses = [&](std::size_t i, const Eigen::Vector2d& direction) {
    const Eigen::Vector2d a = points[i] - centre;
    const Eigen::Vector2d b = Next(points, i) - centre;
    return Cross(a, direction) >= 0.0 && Cross(direction, b) >= 0.0 && direction.dot(a + b) > 0.0;
  };
  std::vector<double> radii(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = kTwoPi * static_cast<double>(i) / static_cast<double>(count);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    for (std::size_t tried = 0; tried < points.size() && !crosses(side, direction); ++tried) {
      side = side + 1 == points.size() ? 0 : side + 1;
    }
    radii[i] = RadiusAt(points[side] - centre, Next(points, side) - centre, direction);
  }
  return radii;
}

LensOutline OutlineFromRadii(const std::vector<double>& radii) {
  LensOutline outline;
  outline.points.reserve(radii.size());
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double angle = kTwoPi * static_cast<double>(i) / static_cast<double>(radii.size());
    outline.points.emplace_back(radii[i] * std::cos(angle), radii[i] * std::sin(angle));
  }
  return outline;
}

LensOutline Mirrored(const LensOutline& outline) {
  LensOutline mirrored;
  mirrored.points.reserve(outline.points.size());
  for (auto point = outline.points.rbegin(); point != outline.points.rend(); ++point) {
    mirrored.points.emplace_back(-point->x(), point->y());
  }
  return mirrored;
}

}  // namespace annulus
