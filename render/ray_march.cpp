#include "render/ray_march.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr double kLongestWay = 3000.0;  // mm behind the lens
constexpr int kMostSteps = 4096;
/// A surface may come towards the ray by this many sample sizes per sample and still be met from the front.
constexpr double kSteepest = 4.0;
constexpr double kFarthestSample = 1e6;

/// The picture of the ray: positions are linear in `share` 0 … 1, and so is 1 / depth (perspective) or depth.
struct RayPicture {
  bool is_perspective = true;
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double at_from = 0.0;  // 1 / depth or depth
  double at_to = 0.0;

  [[nodiscard]] double DepthAt(double share) const {
    const double at = at_from + share * (at_to - at_from);
    return is_perspective ? 1.0 / at : at;
  }
  [[nodiscard]] double ShareOf(double depth) const {
    const double at = is_perspective ? 1.0 / depth : depth;
    return at_to == at_from ? 1.0 : (at - at_from) / (at_to - at_from);
  }
  [[nodiscard]] Eigen::Vector2d PositionAt(double share) const { return from + share * (to - from); }
};

/// Position in samples of a camera-frame point.
Eigen::Vector2d PositionOf(const PixelSamples& grid, const Eigen::Vector3d& p) {
  const double scale = (grid.projection == Projection::kPerspective ? 1.0 / p.z() : 1.0) / grid.Pitch();
  return {0.5 * grid.width - 0.5 + p.x() * scale, 0.5 * grid.height - 0.5 - p.y() * scale};
}

/// How far along the ray things may be met.
double WayOf(const PixelSamples& grid, const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
             double farthest) {
  double way = kLongestWay;
  if (direction.z() > 0.0) way = std::min(way, (std::max(farthest, start.z()) - start.z() + 1.0) / direction.z());
  if (direction.z() < 0.0) way = std::min(way, 0.9 * (start.z() - grid.near_mm) / -direction.z());
  return std::max(way, 0.0);
}

Eigen::Vector2d WithinReason(const Eigen::Vector2d& position) {
  return position.cwiseMin(kFarthestSample).cwiseMax(-kFarthestSample);
}

/// Where a ray that meets nothing points: its vanishing point, or the end of its way.
Eigen::Vector2d VanishingPoint(const PixelSamples& grid, const Eigen::Vector3d& direction, const Eigen::Vector2d& end) {
  if (grid.projection != Projection::kPerspective || direction.z() <= 1e-3) return WithinReason(end);
  return WithinReason(PositionOf(grid, direction));
}

}  // namespace

MarchEnd MarchRay(const OpaquePicture& picture, const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
                  double farthest) {
  const PixelSamples& grid = picture.grid;
  const Eigen::Vector3d end = start + WayOf(grid, start, direction, farthest) * direction;
  const bool is_perspective = grid.projection == Projection::kPerspective;
  const RayPicture ray{is_perspective, PositionOf(grid, start), PositionOf(grid, end),
                       is_perspective ? 1.0 / start.z() : start.z(), is_perspective ? 1.0 / end.z() : end.z()};
  const double length = (ray.to - ray.from).cwiseAbs().maxCoeff();
  const int steps = std::isfinite(length) ? std::clamp(static_cast<int>(std::min(length, 1e6)) + 1, 1, kMostSteps) : 1;
  const auto sample_at = [&ray](double share) {
    const Eigen::Vector2d p = WithinReason(ray.PositionAt(share));
    return std::array<int, 2>{static_cast<int>(std::floor(p.x() + 0.5)), static_cast<int>(std::floor(p.y() + 0.5))};
  };
  double last_in_sight = 0.0;
  double before = ray.DepthAt(0.0);
  bool hidden = false;
  for (int k = 1; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    const double depth = ray.DepthAt(share);
    const auto [x, y] = sample_at(share);
    if (x < 0 || y < 0 || x >= grid.width || y >= grid.height) {
      const auto [seen_x, seen_y] = sample_at(last_in_sight);
      hidden = picture.DepthAt(seen_x, seen_y) != kNoDepth;  // it left the picture over something
      break;
    }
    const double stored = picture.DepthAt(x, y);
    const double sample_size = grid.Pitch() * (is_perspective ? depth : 1.0);
    if (!(depth >= stored)) {
      hidden = false;
      last_in_sight = share;
    } else if (!hidden && stored >= before - kSteepest * sample_size) {
      const double first = static_cast<double>(k - 1) / steps;
      const double met = std::clamp(ray.ShareOf(stored), first, share);
      const Eigen::Vector2d position = ray.PositionAt(met);
      return {MarchEnd::Kind::kMet, position.x(), position.y(), static_cast<float>(stored)};
    } else {
      hidden = true;
    }
    before = depth;
  }
  if (hidden) {
    const Eigen::Vector2d position = ray.PositionAt(last_in_sight);
    return {MarchEnd::Kind::kHidden, position.x(), position.y(), kNoDepth};
  }
  const Eigen::Vector2d position = VanishingPoint(grid, direction, ray.to);
  return {MarchEnd::Kind::kMissed, position.x(), position.y(), kNoDepth};
}

}  // namespace annulus
