#include "modeling/glasses/pad_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "modeling/glasses/frame_skin.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kTouch = 0.01;  // mm
constexpr int kRounds = 4;
constexpr int kNet = 2;  // points from a pad's middle to its edge
constexpr PointDensity kDensity{10, 6};

/// The plane through the skin under a pad (least squares), seen along `normal`: its normal and its point.
struct SkinPlane {
  Vector3d point;
  Vector3d normal;
};

SkinPlane PlaneUnder(const HeadDistance& skin, const Vector3d& centre, const Vector3d& normal, const Vector3d& up,
                     double half_length, double half_width) {
  const Vector3d across = up.cross(normal);
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (int i = -kNet; i <= kNet; ++i) {
    for (int j = -kNet; j <= kNet; ++j) {
      if (i * i + j * j > kNet * kNet) continue;
      const double a = half_length * i / kNet;
      const double b = half_width * j / kNet;
      const double height = -skin.Nearest(centre + a * up + b * across).distance;
      const Vector3d row(1.0, a, b);
      square += row * row.transpose();
      right += height * row;
    }
  }
  // Heights of the skin over the plane through `centre`, out of the head.
  const Vector3d fit = square.ldlt().solve(right);
  const Vector3d out = (normal - fit[1] * up - fit[2] * across).normalized();
  return {centre + fit[0] * normal, out};
}

/// The pad's pose, station frame, laid on the skin nearest to its usual centre. `out` is outward of the head.
PadPose LayPad(const WearerHead& head, const FrameDetails& details, const Vector3d& usual, const Vector3d& up) {
  const NearestOnHead foot = head.skin().Nearest(usual);
  SkinPlane plane{foot.position, head.skin().surface().Normal(foot.theta, foot.z)};
  Vector3d along = up;
  for (int round = 0; round < 2; ++round) {
    along = (up - up.dot(plane.normal) * plane.normal).normalized();
    plane =
        PlaneUnder(head.skin(), plane.point, plane.normal, along, 0.5 * details.pad_length, 0.5 * details.pad_width);
  }
  along = (up - up.dot(plane.normal) * plane.normal).normalized();
  return {plane.point, -plane.normal, along};
}

PadPose InFrame(const PadPose& pose, const Eigen::Isometry3d& frame_from_station) {
  return {frame_from_station * pose.centre, frame_from_station.linear() * pose.normal,
          frame_from_station.linear() * pose.up};
}

}  // namespace

Result<std::optional<std::array<PadFit, 2>>> FitPads(const WearerHead& head, const FrameDesign& design,
                                                     const Eigen::Isometry3d& station_from_frame) {
  using Pads = std::optional<std::array<PadFit, 2>>;
  if (design.details.pads != PadForm::kAdjustable) return Pads();
  FrameAdjustment adjustment = StandardAdjustment(design);
  const std::array<Vector3d, 2> usual{adjustment.pad_right.centre, adjustment.pad_left.centre};
  const std::array<Vector3d, 2> up{adjustment.pad_right.up, adjustment.pad_left.up};
  const Eigen::Isometry3d frame_from_station = station_from_frame.inverse();
  std::array<PadFit, 2> pads;
  for (std::size_t side = 0; side < 2; ++side) {
    pads[side].pose =
        InFrame(LayPad(head, design.details, station_from_frame * usual[side], station_from_frame.linear() * up[side]),
                frame_from_station);
  }
  for (int round = 0; round < kRounds; ++round) {
    adjustment.pad_right = pads[0].pose;
    adjustment.pad_left = pads[1].pose;
    auto shells = FrontShells(design, adjustment);
    RETURN_IF_ERROR(shells);
    std::erase_if(*shells, [](const FrameShell& shell) { return shell.role != FrameRole::kPad; });
    const FrameSkin skin(*shells);
    WornPose pose;
    pose.head = &head;
    pose.station_from_frame = station_from_frame;
    const std::vector<SkinPlace> places = skin.Measure(pose, kDensity, 3.0);
    for (std::size_t side = 0; side < 2; ++side) {
      const SkinPlace least = skin.Least(
          pose, kDensity, places, [&](const SkinPlace& place) { return (place.position.x() > 0.0) == (side == 0); });
      pads[side].distance = least.distance;
      pads[side].moved = (pads[side].pose.centre - usual[side]).norm();
      if (least.distance < 1e6 && round + 1 < kRounds) {
        pads[side].pose.centre += (least.distance - kTouch) * pads[side].pose.normal;
      }
    }
  }
  return Pads(pads);
}

}  // namespace annulus
