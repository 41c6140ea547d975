#include "modeling/glasses/frame_points.h"

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr int kEdgeSteps = 12;  // points on each side of a lens' patch

bool StartsWith(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

void AddPatch(const ShellPatch& shell_patch, const PointDensity& density, std::vector<Vector3d>& points) {
  const auto steps = [&](PatchDetail detail) { return detail == PatchDetail::kAlong ? density.along : density.around; };
  const int count_u = steps(shell_patch.u);
  const int count_v = steps(shell_patch.v);
  // Each edge belongs to two patches: the end of one is the start of the next.
  for (int i = 0; i < count_u; ++i) {
    for (int j = 0; j < count_v; ++j) {
      points.push_back(shell_patch.patch.Point(static_cast<double>(i) / count_u, static_cast<double>(j) / count_v));
    }
  }
}

}  // namespace

FrameRole RoleOfPart(const std::string& body, const std::string& shell) {
  if (StartsWith(body, "temple") || StartsWith(shell, "arm")) return FrameRole::kTemple;
  if (StartsWith(shell, "pad_wire")) return FrameRole::kPadArm;
  if (StartsWith(shell, "pad")) return FrameRole::kPad;
  if (StartsWith(shell, "bridge") || StartsWith(shell, "flank")) return FrameRole::kBridge;
  if (StartsWith(shell, "end_piece") || StartsWith(shell, "knuckle") || StartsWith(shell, "leaf")) {
    return FrameRole::kEndPiece;
  }
  return FrameRole::kRim;
}

std::vector<PartPoints> SampleFrame(const Frame& frame, const PointDensity& density, PointChoice choice) {
  std::vector<PartPoints> parts;
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      const FrameRole role = RoleOfPart(body.name, shell.name);
      const bool is_temple = role == FrameRole::kTemple;
      if ((choice == PointChoice::kFront && is_temple) || (choice == PointChoice::kTemples && !is_temple)) continue;
      PartPoints part{shell.name, role, {}};
      for (const ShellPatch& patch : shell.patches) AddPatch(patch, density, part.points);
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

LensPlane LensPlaneOf(const Frame& frame, Eye eye) {
  const BezierPatch& lens = eye == Eye::kRight ? frame.lens_right : frame.lens_left;
  std::vector<Vector3d> edge;
  for (int k = 0; k < kEdgeSteps; ++k) edge.push_back(lens.Point(static_cast<double>(k) / kEdgeSteps, 0.0));
  for (int k = 0; k < kEdgeSteps; ++k) edge.push_back(lens.Point(1.0, static_cast<double>(k) / kEdgeSteps));
  for (int k = 0; k < kEdgeSteps; ++k) edge.push_back(lens.Point(1.0 - static_cast<double>(k) / kEdgeSteps, 1.0));
  for (int k = 0; k < kEdgeSteps; ++k) edge.push_back(lens.Point(0.0, 1.0 - static_cast<double>(k) / kEdgeSteps));
  // Newell's normal of the closed outline; the mean of the edge lies in its plane.
  Vector3d area = Vector3d::Zero();
  Vector3d mean = Vector3d::Zero();
  for (std::size_t k = 0; k < edge.size(); ++k) {
    area += edge[k].cross(edge[(k + 1) % edge.size()]);
    mean += edge[k] / static_cast<double>(edge.size());
  }
  LensPlane plane;
  plane.forward = area.y() >= 0.0 ? area.normalized() : Vector3d(-area.normalized());
  plane.right = plane.forward.cross(Vector3d::UnitZ()).normalized();
  plane.up = plane.right.cross(plane.forward);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const Vector3d& p : edge) {
    plane.outline.emplace_back((p - mean).dot(plane.right), (p - mean).dot(plane.up));
    low = low.cwiseMin(plane.outline.back());
    high = high.cwiseMax(plane.outline.back());
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  for (Eigen::Vector2d& p : plane.outline) p -= middle;
  plane.centre = mean + middle.x() * plane.right + middle.y() * plane.up;
  plane.a = high.x() - low.x();
  plane.b = high.y() - low.y();
  return plane;
}

}  // namespace annulus
