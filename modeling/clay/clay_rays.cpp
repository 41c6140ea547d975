#include "modeling/clay/clay_rays.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

constexpr const char* kAttempted = "make a surface r(theta, z) of a clay body";
constexpr const char* kAdvice = "keep the clay body as it is, or undo what turned the skin away";
constexpr std::size_t kPlaces = 6;  ///< Each way, on every leaf, edges included.
constexpr std::size_t kFloors = 512;
constexpr int kSteps = 40;
constexpr double kMargin = 1e-7;  ///< Of a leaf's parameters, so that no ray falls between two.

Eigen::AlignedBox3d BoxOf(const ControlNet& net) {
  Eigen::AlignedBox3d box;
  for (const auto& row : net) {
    for (const Vector3d& control : row) box.extend(control);
  }
  return box;
}

/// The number of ∂(theta, z)/∂(u, v) times the square of the distance from the axis: positive where the wall is seen
/// from the axis' own height, from inside.
double SeenFromAxis(const BezierPatch& patch, const SegmentAxis& axis, double u, double v) {
  const Vector3d point = patch.Point(u, v);
  const Vector3d along_u = patch.DerivativeU(u, v);
  const Vector3d along_v = patch.DerivativeV(u, v);
  const Vector2d lean = axis.slope + 2.0 * (point.z() - axis.z_middle) * axis.bend;
  const Vector2d arm = point.head<2>() - axis.At(point.z());
  const auto turn = [&](const Vector3d& step) {
    const Vector2d aside = step.head<2>() - step.z() * lean;
    return arm.x() * aside.y() - arm.y() * aside.x();
  };
  return turn(along_u) * along_v.z() - turn(along_v) * along_u.z();
}

Status CheckStar(const ClayMesh& mesh, const SegmentAxis& axis, std::size_t walls) {
  for (const PatchIndex index : mesh.LeavesInOrder()) {
    const ClayPatch& leaf = mesh.patch(index);
    if (leaf.base >= walls) break;
    const BezierPatch patch(leaf.net);
    for (std::size_t n = 0; n < kPlaces * kPlaces; ++n) {
      const double u = static_cast<double>(n % kPlaces) / static_cast<double>(kPlaces - 1);
      const double v = static_cast<double>(n / kPlaces) / static_cast<double>(kPlaces - 1);
      if (SeenFromAxis(patch, axis, u, v) > 0.0) continue;
      const Vector3d at = patch.Point(u, v);
      const Vector2d arm = at.head<2>() - axis.At(at.z());
      return Fail(kAttempted,
                  fmt::format("on patch {}, at theta {:.1f} deg, z {:.1f} mm, {:.1f} mm from the axis, its skin is "
                              "undercut: seen from the axis it lies behind itself",
                              leaf.base, std::atan2(arm.y(), arm.x()) * 180.0 / std::numbers::pi, at.z(), arm.norm()),
                  kAdvice);
    }
  }
  return {};
}

/// A level half-line: from `from` at height z along `out`.
struct LevelRay {
  Vector2d from, out;
  double z = 0.0;
};

/// Newton from a start; nothing if it does not end on the patch.
std::optional<double> DistanceFrom(const BezierPatch& patch, const LevelRay& ray, Vector2d at) {
  const Vector2d across(-ray.out.y(), ray.out.x());
  for (int step = 0; step < kSteps; ++step) {
    const Vector3d point = patch.Point(at.x(), at.y());
    const Vector2d arm = point.head<2>() - ray.from;
    const Vector2d off(across.dot(arm), point.z() - ray.z);
    const Vector3d along_u = patch.DerivativeU(at.x(), at.y());
    const Vector3d along_v = patch.DerivativeV(at.x(), at.y());
    Eigen::Matrix2d slope;
    slope << across.dot(along_u.head<2>()), across.dot(along_v.head<2>()), along_u.z(), along_v.z();
    const double determinant = slope.determinant();
    if (determinant == 0.0 || !std::isfinite(determinant)) return std::nullopt;
    const Vector2d move = -slope.inverse() * off;
    if (off.cwiseAbs().maxCoeff() < 1e-10 && move.cwiseAbs().maxCoeff() < 1e-8) {
      const bool inside = at.minCoeff() >= -kMargin && at.maxCoeff() <= 1.0 + kMargin;
      const double distance = ray.out.dot(arm);
      if (!inside || !(distance > 0.0)) return std::nullopt;
      return distance;
    }
    at = (at + move).cwiseMax(-0.25).cwiseMin(1.25);
  }
  return std::nullopt;
}

/// Whether all control points are on one side of the upright plane through the ray: then so is the patch.
bool Beside(const ControlNet& net, const LevelRay& ray) {
  const Vector2d across(-ray.out.y(), ray.out.x());
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const auto& row : net) {
    for (const Vector3d& control : row) {
      const double side = across.dot(control.head<2>() - ray.from);
      least = std::min(least, side);
      most = std::max(most, side);
    }
  }
  return least > 1e-6 || most < -1e-6;
}

std::optional<double> DistanceTo(const BezierPatch& patch, const LevelRay& ray) {
  if (Beside(patch.control_net(), ray)) return std::nullopt;
  for (const Vector2d& start :
       {Vector2d(0.5, 0.5), Vector2d(0.15, 0.15), Vector2d(0.85, 0.15), Vector2d(0.85, 0.85), Vector2d(0.15, 0.85)}) {
    if (const auto found = DistanceFrom(patch, ray, start)) return found;
  }
  return std::nullopt;
}

/// Whether the ray passes through the box seen from above.
bool Passes(const LevelRay& ray, const Vector3d& low, const Vector3d& high) {
  double from = 0.0;
  double to = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double before = low[k] - 1e-6 - ray.from[k];
    const double behind = high[k] + 1e-6 - ray.from[k];
    if (std::abs(ray.out[k]) < 1e-15) {
      if (before > 0.0 || behind < 0.0) return false;
      continue;
    }
    const double first = before / ray.out[k];
    const double last = behind / ray.out[k];
    from = std::max(from, std::min(first, last));
    to = std::min(to, std::max(first, last));
  }
  return from <= to;
}

}  // namespace

Result<ClayRays> ClayRays::Make(const ClayBody& body, const SegmentAxis& axis, std::size_t walls) {
  RETURN_IF_ERROR(CheckStar(body.mesh(), axis, walls));
  ClayRays rays;
  rays.body_ = &body;
  rays.axis_ = axis;
  rays.FindCaps(walls);
  if (!(rays.z_min_ < rays.z_max_)) {
    return Fail(kAttempted,
                fmt::format("its lower cap reaches up to z {:.1f} mm, its upper one down to {:.1f} mm", rays.z_min_,
                            rays.z_max_),
                kAdvice);
  }
  rays.FillFloors(walls);
  return rays;
}

void ClayRays::FindCaps(std::size_t walls) {
  const ClayMesh& mesh = body_->mesh();
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const std::size_t upper = walls + (mesh.base_count() - walls) / 2;
  std::array<double, 4> height{kFar, -kFar, kFar, -kFar};  // of the lower cap from and to, of the upper cap
  for (const PatchIndex index : mesh.LeavesInOrder()) {
    const ClayPatch& leaf = mesh.patch(index);
    if (leaf.base < walls) continue;
    const Eigen::AlignedBox3d box = BoxOf(leaf.net);
    const std::size_t first = leaf.base < upper ? 0 : 2;
    height[first] = std::min(height[first], box.min().z());
    height[first + 1] = std::max(height[first + 1], box.max().z());
  }
  z_min_ = height[1];
  z_max_ = height[2];
  caps_off_ = std::max(height[1] - height[0], height[3] - height[2]);
}

void ClayRays::FillFloors(std::size_t walls) {
  floors_.resize(kFloors);
  const ClayMesh& mesh = body_->mesh();
  for (const PatchIndex index : mesh.LeavesInOrder()) {
    if (mesh.patch(index).base >= walls) continue;
    const Eigen::AlignedBox3d box = BoxOf(mesh.patch(index).net);
    const std::size_t last = FloorOf(box.max().z());
    for (std::size_t floor = FloorOf(box.min().z()); floor <= last; ++floor) {
      floors_[floor].push_back({index, box.min(), box.max()});
    }
  }
}

std::size_t ClayRays::FloorOf(double z) const {
  const double share = (z - z_min_) / (z_max_ - z_min_) * static_cast<double>(kFloors);
  return static_cast<std::size_t>(std::clamp(share, 0.0, static_cast<double>(kFloors - 1)));
}

std::optional<ClayRays::Hit> ClayRays::Meet(double theta, double z) const {
  const LevelRay ray{axis_.At(z), Vector2d(std::cos(theta), std::sin(theta)), z};
  for (const Piece& piece : floors_[FloorOf(z)]) {
    if (z < piece.low.z() - 1e-6 || z > piece.high.z() + 1e-6 || !Passes(ray, piece.low, piece.high)) continue;
    const auto radius = DistanceTo(BezierPatch(body_->mesh().patch(piece.leaf).net), ray);
    if (radius) return Hit{*radius, piece.leaf};
  }
  return std::nullopt;
}

}  // namespace annulus
