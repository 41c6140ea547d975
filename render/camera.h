#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// Where the camera stands, seen from the subject.
struct View {
  double azimuth = 0.0;    ///< rad, station theta of the camera; front is 90 degrees.
  double elevation = 0.0;  ///< rad, -pi/2 … pi/2; positive looks down on the subject.
};

/// "front" (90 degrees), "left45" (135), "right45" (45), where left and right are the subject's, or "AZ,EL" in degrees.
/// Fails on another word, a missing number, or EL outside -90 … 90.
[[nodiscard]] Result<View> ParseView(std::string_view text);

enum class Projection { kPerspective, kOrthographic };

/// A pinhole or parallel camera. Camera frame: x to the right of the picture, y up in the picture, z away from the eye.
/// The picture's height spans -half_height … +half_height; its width follows from the image's width : height.
struct Camera {
  Projection projection = Projection::kPerspective;
  Eigen::Matrix3d camera_from_station = Eigen::Matrix3d::Identity();  ///< Rotation; rows are right, up, forward.
  Eigen::Vector3d eye_in_station = Eigen::Vector3d::Zero();           ///< mm.
  double half_height = 0.2;  ///< Perspective: tangent of half the vertical field of view. Orthographic: mm.
  double near_mm = 1.0;      ///< Nothing nearer than this along the optical axis is drawn; > 0.

  /// `p_in_station` (mm) in the camera frame, mm.
  [[nodiscard]] Eigen::Vector3d ToCamera(const Eigen::Vector3d& p_in_station) const {
    return camera_from_station * (p_in_station - eye_in_station);
  }
};

/// How FrameCamera chooses distance or scale.
struct Framing {
  Projection projection = Projection::kPerspective;
  double aspect = 1.0;                   ///< Width : height of the picture, > 0.
  double margin = 0.06;                  ///< Free share of the half picture on each side, 0 … 0.9.
  double vertical_field_of_view = 0.42;  ///< rad, 0.01 … 2.5; perspective only. Narrow, as portraits are taken.
};

/// The camera that sees the whole of `bounds` (station frame, mm) from `view`, as large as the margins allow.
/// Fails on empty or non-finite bounds, or framing out of range.
[[nodiscard]] Result<Camera> FrameCamera(const Eigen::AlignedBox3d& bounds, const View& view, const Framing& framing);

}  // namespace annulus
