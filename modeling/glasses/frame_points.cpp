#include "modeling/glasses/frame_points.h"

#include <algorithm>
#include <array>
#include <utility>

#include "modeling/glasses/frame_assembly.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr int kEdgeSteps = 12;  // points on each of a lens' four curves

bool StartsWith(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

Vector3d MirroredX(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

PadPose MirroredX(const PadPose& pose) { return {MirroredX(pose.centre), MirroredX(pose.normal), MirroredX(pose.up)}; }

/// Both temples as right ones.
Result<std::array<FrameArm, 2>> ArmsOf(const FrameDesign& design, const Rim& rim, const FrameAdjustment& adjustment) {
  TempleShape shape_left = adjustment.temple_left;
  shape_left.ear = MirroredX(shape_left.ear);
  const TubeSection root = TempleRoot(design, rim);
  const Result<FrameArm> right = MakeArm(design, root, adjustment.temple_right, "right");
  RETURN_IF_ERROR(right);
  const Result<FrameArm> left = MakeArm(design, root, shape_left, "left");
  RETURN_IF_ERROR(left);
  return std::array<FrameArm, 2>{*right, *left};
}

/// The arm without hinge that has the end piece for its whole temple.
FrameArm FrontEnd(FrameArm arm) {
  if (!arm.end_piece.empty()) arm.temple = arm.end_piece;
  arm.hinge.reset();
  return arm;
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

std::vector<FrameShell> ShellsOf(const Frame& frame) {
  std::vector<FrameShell> shells;
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      shells.push_back({shell.name, RoleOfPart(body.name, shell.name), shell});
    }
  }
  return shells;
}

Result<std::vector<FrameShell>> FrontShells(const FrameDesign& design, const FrameAdjustment& adjustment) {
  RETURN_IF_ERROR(Validate(design));
  const Rim rim = MakeRim(design);
  const auto arms = ArmsOf(design, rim, adjustment);
  RETURN_IF_ERROR(arms);
  const std::vector<BezierTube> bridge = MakeBridge(design, BridgeRoot(design, rim));
  const bool has_end_piece = !(*arms)[0].end_piece.empty();
  std::vector<FrameShell> shells;
  for (const FrameBody& body : AssembleBodies({design,
                                               rim,
                                               bridge,
                                               {FrontEnd((*arms)[0]), adjustment.pad_right},
                                               {FrontEnd((*arms)[1]), MirroredX(adjustment.pad_left)}})) {
    for (const PatchShell& shell : body.shells) {
      const FrameRole role = RoleOfPart("front", shell.name);
      if (role == FrameRole::kTemple && !has_end_piece) continue;
      shells.push_back({shell.name, role == FrameRole::kTemple ? FrameRole::kEndPiece : role, shell});
    }
  }
  return shells;
}

Result<std::vector<FrameShell>> TempleShells(const FrameDesign& design, const FrameAdjustment& adjustment) {
  RETURN_IF_ERROR(Validate(design));
  const auto arms = ArmsOf(design, MakeRim(design), adjustment);
  RETURN_IF_ERROR(arms);
  return std::vector<FrameShell>{
      {"temple_right", FrameRole::kTemple, ShellOfTubes("temple_right", (*arms)[0].temple, TubeEnds::kCapped)},
      {"temple_left", FrameRole::kTemple,
       ShellOfTubes("temple_left", MirroredX((*arms)[1]).temple, TubeEnds::kCapped)}};
}

int StepsOf(PatchDetail detail, const PointDensity& density) {
  if (detail == PatchDetail::kAlong) return density.along;
  return detail == PatchDetail::kAround ? density.around : std::max(density.around / 2, 1);
}

std::vector<Vector3d> SamplePoints(const PatchShell& shell, const PointDensity& density) {
  std::vector<Vector3d> points;
  for (const ShellPatch& patch : shell.patches) {
    const int count_u = StepsOf(patch.u, density);
    const int count_v = StepsOf(patch.v, density);
    // Each edge belongs to two patches: the end of one is the start of the next.
    for (int i = 0; i < count_u; ++i) {
      for (int j = 0; j < count_v; ++j) {
        points.push_back(patch.patch.Point(static_cast<double>(i) / count_u, static_cast<double>(j) / count_v));
      }
    }
  }
  return points;
}

LensPlane LensPlaneOf(const Rim& rim, Eye eye) {
  const auto sided = [eye](const Vector3d& v) { return eye == Eye::kRight ? v : MirroredX(v); };
  LensPlane plane;
  plane.forward = sided(rim.frame_from_rim.linear().col(1));
  plane.right = plane.forward.cross(Vector3d::UnitZ()).normalized();
  plane.up = plane.right.cross(plane.forward);
  const Vector3d origin = sided(rim.frame_from_rim.translation());
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (std::size_t k = 0; k < 4; ++k) {
    const BezierCurve curve = LensCurve(rim, k);
    for (int step = 0; step < kEdgeSteps; ++step) {
      const Vector3d off = sided(CubicBezierPoint(curve, static_cast<double>(step) / kEdgeSteps)) - origin;
      plane.outline.emplace_back(off.dot(plane.right), off.dot(plane.up));
      low = low.cwiseMin(plane.outline.back());
      high = high.cwiseMax(plane.outline.back());
    }
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  for (Eigen::Vector2d& p : plane.outline) p -= middle;
  plane.centre = origin + middle.x() * plane.right + middle.y() * plane.up;
  plane.a = high.x() - low.x();
  plane.b = high.y() - low.y();
  return plane;
}

}  // namespace annulus
