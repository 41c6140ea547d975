#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "render/camera.h"

namespace annulus {

/// The camera that sees all points (station frame, mm) from a view, as large as the margins allow: for pictures that
/// are looked at side by side, each of which shows some of them. Fails as FrameCamera.
[[nodiscard]] Result<Camera> CameraForAll(const std::vector<Eigen::Vector3d>& points, const View& view,
                                          const Framing& framing);

/// `count` cameras around the points at one distance and scale, the first from `start`, each 360/count degrees of
/// azimuth further; all points stay in the picture all the way round. Fails as FrameCamera, or on a count that is not
/// 1 … 720.
[[nodiscard]] Result<std::vector<Camera>> CamerasAround(const std::vector<Eigen::Vector3d>& points, const View& start,
                                                        int count, const Framing& framing);

}  // namespace annulus
