#include "station/shared_camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/units.h"

namespace annulus {
namespace {

Eigen::AlignedBox3d BoxOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box;
}

/// What half the picture's height must show of the points: a slope or mm.
double Needed(const std::vector<Eigen::Vector3d>& points, const Camera& camera, const Framing& framing) {
  double needed = 0.0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = camera.ToCamera(point);
    const double scale = framing.projection == Projection::kPerspective ? p.z() : 1.0;
    needed = std::max(needed, std::max(std::abs(p.y()), std::abs(p.x()) / framing.aspect) / scale);
  }
  return needed;
}

}  // namespace

Result<Camera> CameraForAll(const std::vector<Eigen::Vector3d>& points, const View& view, const Framing& framing) {
  auto camera = FrameCamera(BoxOf(points), view, framing);
  if (!camera) return Fail(camera);
  // A box around a head is larger than the head.
  camera->half_height = std::min(camera->half_height, Needed(points, *camera, framing) / (1.0 - framing.margin));
  return camera;
}

Result<std::vector<Camera>> CamerasAround(const std::vector<Eigen::Vector3d>& points, const View& start, int count,
                                          const Framing& framing) {
  if (count < 1 || count > 720) {
    return Fail("place cameras around a subject", std::to_string(count) + " frames", "give 1 ... 720");
  }
  // The upright cylinder around the points' box: the same from all sides.
  const Eigen::AlignedBox3d box = BoxOf(points);
  const Eigen::Vector3d centre = box.center();
  double radius = 0.0;
  for (const Eigen::Vector3d& p : points) radius = std::max(radius, (p - centre).head<2>().norm());
  Eigen::AlignedBox3d round;
  if (!box.isEmpty()) {
    const Eigen::Vector3d half(radius, radius, 0.5 * box.sizes().z());
    round.extend(Eigen::Vector3d(centre - half));
    round.extend(Eigen::Vector3d(centre + half));
  }
  const auto first = FrameCamera(round, start, framing);
  if (!first) return Fail(first);
  const double distance = (first->eye_in_station - centre).norm();
  std::vector<Camera> cameras;
  double needed = 0.0;
  for (int k = 0; k < count; ++k) {
    View view = start;
    view.azimuth += kTwoPi * k / count;
    auto camera = FrameCamera(round, view, framing);
    if (!camera) return Fail(camera);
    camera->eye_in_station = centre - distance * camera->camera_from_station.row(2).transpose();
    camera->near_mm = first->near_mm;
    needed = std::max(needed, Needed(points, *camera, framing));
    cameras.push_back(*camera);
  }
  for (Camera& camera : cameras) camera.half_height = needed / (1.0 - framing.margin);
  return cameras;
}

}  // namespace annulus
