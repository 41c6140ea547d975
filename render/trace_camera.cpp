#include "render/trace_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

/// A point in the picture, pixels. At the near plane it is neither ahead nor behind.
struct ProjectedPoint {
  float x = 0.0F;
  float y = 0.0F;
  bool is_ahead = false;
  bool is_behind = false;
};

/// The pixels that something may cover.
class CoverageMask {
 public:
  CoverageMask(int width, int height)
      : width_(width), height_(height), cells_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  void Fill() {
    std::fill(cells_.begin(), cells_.end(), std::uint8_t{1});
    is_full_ = true;
  }

  /// Marks the rectangle about some points.
  template <std::size_t N>
  void Mark(const std::array<ProjectedPoint, N>& points) {
    constexpr float kRoom = 0.05F;  // pixels: more than rays in float are off
    float left = points[0].x, right = left, top = points[0].y, bottom = top;
    bool all_behind = true;
    bool all_ahead = true;
    for (const ProjectedPoint& p : points) {
      all_behind = all_behind && p.is_behind;
      all_ahead = all_ahead && p.is_ahead;
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      top = std::min(top, p.y);
      bottom = std::max(bottom, p.y);
    }
    if (is_full_ || all_behind) return;
    if (!all_ahead) return Fill();
    const int x_from = ToPixel(left - kRoom, width_);
    const int x_to = ToPixel(right + kRoom, width_);
    const int y_from = ToPixel(top - kRoom, height_);
    const int y_to = ToPixel(bottom + kRoom, height_);
    if (right + kRoom < 0.0F || bottom + kRoom < 0.0F || left - kRoom > static_cast<float>(width_) ||
        top - kRoom > static_cast<float>(height_)) {
      return;
    }
    for (int y = y_from; y <= y_to; ++y) {
      const auto row = cells_.begin() + static_cast<std::ptrdiff_t>(y) * width_;
      std::fill(row + x_from, row + x_to + 1, std::uint8_t{1});
    }
    // Large triangles in large numbers: marking must not take longer than tracing.
    marked_ += static_cast<std::size_t>(x_to - x_from + 1) * static_cast<std::size_t>(y_to - y_from + 1);
    if (marked_ > 64 * cells_.size() + 1'000'000) Fill();
  }

  [[nodiscard]] std::vector<std::uint8_t> Take() && { return std::move(cells_); }

 private:
  static int ToPixel(float position, int size) {
    return static_cast<int>(std::clamp(std::floor(position), 0.0F, static_cast<float>(size - 1)));
  }

  int width_;
  int height_;
  std::vector<std::uint8_t> cells_;
  std::size_t marked_ = 0;
  bool is_full_ = false;
};

}  // namespace

TraceCamera::TraceCamera(const Camera& camera, const TraceScene& scene, int width, int height)
    : camera_(camera),
      width_(width),
      height_(height),
      pitch_(2.0 * camera.half_height / height),
      eye_(camera.eye_in_station - scene.centre()),
      radius_(scene.radius()),
      forward_(camera.camera_from_station.row(2).cast<float>()),
      eye_depth_(static_cast<float>(camera.camera_from_station.row(2).dot(eye_))) {
  towards_eye_from_trace_ = camera.camera_from_station.cast<float>();
  towards_eye_from_trace_.row(2) *= -1.0F;
}

TraceRay TraceCamera::RayAt(int x, int y, const Eigen::Vector2f& offset) const {
  const double u = (static_cast<double>(x) + static_cast<double>(offset.x()) - 0.5 * width_) * pitch_;
  const double v = (0.5 * height_ - static_cast<double>(y) - static_cast<double>(offset.y())) * pitch_;
  const bool is_perspective = camera_.projection == Projection::kPerspective;
  const Eigen::Vector3d in_camera = is_perspective ? Eigen::Vector3d(u, v, 1.0) : Eigen::Vector3d(0.0, 0.0, 1.0);
  const double length = in_camera.norm();
  const Eigen::Vector3d direction = camera_.camera_from_station.transpose() * (in_camera / length);
  Eigen::Vector3d origin = eye_;
  if (!is_perspective) origin += camera_.camera_from_station.transpose() * Eigen::Vector3d(u, v, 0.0);
  // To the near plane, or, from far away, into the sphere that holds the scene: floats are fine enough there.
  const double to_near = camera_.near_mm * length;
  const double to_sphere = -origin.dot(direction) - 2.0 * radius_;
  origin += std::max(to_near, to_sphere) * direction;
  return {origin.cast<float>(), 0.0F, direction.cast<float>()};
}

Eigen::Matrix3f TraceCamera::LightFromTrace() const {
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f right = camera_.camera_from_station.row(0).transpose().cast<float>();
  right.z() = 0.0F;
  // A camera that lies on its side still has an azimuth, unless it looks along its horizontal.
  if (right.norm() < 1e-3F) right = up.cross(Eigen::Vector3f(-forward_));
  if (right.norm() < 1e-3F) right = Eigen::Vector3f::UnitX();
  right.normalize();
  Eigen::Matrix3f light_from_trace;
  light_from_trace << right.transpose(), up.transpose(), right.cross(up).transpose();
  return light_from_trace;
}

std::vector<std::uint8_t> TraceCamera::Coverage(const TraceScene& scene) const {
  CoverageMask mask(width_, height_);
  const bool is_perspective = camera_.projection == Projection::kPerspective;
  const Eigen::Matrix3d& rotation = camera_.camera_from_station;
  const Eigen::Vector3d shift = -rotation * eye_;
  const auto project = [&](const Eigen::Vector3f& p) -> ProjectedPoint {
    const Eigen::Vector3d c = rotation * p.cast<double>() + shift;
    const double scale = is_perspective ? 1.0 / (pitch_ * c.z()) : 1.0 / pitch_;
    return {static_cast<float>(0.5 * width_ + c.x() * scale), static_cast<float>(0.5 * height_ - c.y() * scale),
            c.z() > 1.001 * camera_.near_mm, c.z() < 0.999 * camera_.near_mm};
  };
  // Pixels so small that rays in float may miss them are all traced.
  const double pixel = is_perspective ? pitch_ * std::max(camera_.near_mm, eye_.norm() - radius_) : pitch_;
  const bool is_exact = pixel > 2e-5 * radius_;
  if (!is_exact) mask.Fill();
  std::vector<ProjectedPoint> points;
  for (const TraceScene::Item& item : scene.items()) {
    points.resize(item.vertices.size());
    for (std::size_t k = 0; k < points.size(); ++k) points[k] = project(item.vertices[k].point);
    for (const auto& face : item.faces) {
      mask.Mark(std::array<ProjectedPoint, 3>{points[face[0]], points[face[1]], points[face[2]]});
    }
  }
  for (const Eigen::AlignedBox3f& box : scene.optics_boxes()) {
    std::array<ProjectedPoint, 8> corners;
    for (int k = 0; k < 8; ++k) {
      corners[static_cast<std::size_t>(k)] = project(box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(k)));
    }
    mask.Mark(corners);
  }
  return std::move(mask).Take();
}

}  // namespace annulus
