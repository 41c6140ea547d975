#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "render/camera.h"
#include "render/trace_scene.h"

namespace annulus {

/// A camera ready to send rays into a TraceScene: the pixels of camera.h and PixelSamples, any point within a pixel.
class TraceCamera {
 public:
  /// `width`, `height` in pixels. Borrows nothing.
  TraceCamera(const Camera& camera, const TraceScene& scene, int width, int height);

  /// The ray through pixel (x, y) at `offset` from its upper left corner, in pixels. It begins at the near plane, or
  /// where it first can meet something.
  [[nodiscard]] TraceRay RayAt(int x, int y, const Eigen::Vector2f& offset) const;
  /// Depth of a point of the trace frame along the optical axis, mm.
  [[nodiscard]] float DepthOf(const Eigen::Vector3f& point) const { return forward_.dot(point) - eye_depth_; }
  /// A direction of the trace frame in the camera frame with z towards the eye.
  [[nodiscard]] Eigen::Vector3f InCamera(const Eigen::Vector3f& direction) const {
    return towards_eye_from_trace_ * direction;
  }
  /// Rotation into the light frame of environment.h.
  [[nodiscard]] Eigen::Matrix3f LightFromTrace() const;

  /// Per pixel, row-major: 0 where no ray can meet a triangle, a lens or a sheet; 1 where one may.
  [[nodiscard]] std::vector<std::uint8_t> Coverage(const TraceScene& scene) const;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

 private:
  Camera camera_;
  int width_;
  int height_;
  double pitch_;             // of a pixel: slope or mm
  Eigen::Vector3d eye_;      // trace frame
  double radius_;            // of the scene about the trace frame's origin, mm
  Eigen::Vector3f forward_;  // optical axis
  float eye_depth_;
  Eigen::Matrix3f towards_eye_from_trace_;
};

}  // namespace annulus
