#include "modeling/glasses/frame.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "modeling/bezier/tube_chain.h"
#include "modeling/glasses/frame_assembly.h"
#include "modeling/glasses/hidden_end.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// l6 / l1 of a frame that nobody wears.
constexpr double kStraightArmShare = 1.7;
/// Points of a lens' outline on each of the rim's four tubes.
constexpr int kOutlineSteps = 180;
/// A pad farther than this from its place on the rim is no pad's, mm.
constexpr double kLongestPadArm = 40.0;

Vector3d MirroredX(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

PadPose MirroredX(const PadPose& pose) { return {MirroredX(pose.centre), MirroredX(pose.normal), MirroredX(pose.up)}; }

/// A pose of the right side.
Status CheckPad(const FrameDesign& design, const Rim& rim, const PadPose& pose, const char* side_name) {
  if (design.details.pads == PadForm::kNone) return {};
  const std::string attempt = fmt::format("place the {} pad", side_name);
  constexpr double kUnit = 1e-6;
  if (!pose.centre.allFinite() || !(std::abs(pose.normal.norm() - 1.0) < kUnit) ||
      !(std::abs(pose.up.norm() - 1.0) < kUnit) || !(std::abs(pose.normal.dot(pose.up)) < kUnit)) {
    return Fail(attempt, "its pose is not a point and two perpendicular unit vectors", "normalise normal and up");
  }
  const Vector3d on_rim = CentreLineAt(rim, RimSide::kNose, pose.centre.z());
  const double distance = (pose.centre - on_rim).norm();
  if (distance > kLongestPadArm || pose.normal.dot(rim.frame_from_rim.linear().col(0)) > -0.1) {
    return Fail(attempt, fmt::format("it is {:.1f} mm from the rim, or faces away from the nose", distance),
                fmt::format("choose a place within {:.0f} mm of the rim and a normal to the nose", kLongestPadArm));
  }
  return {};
}

}  // namespace

Vector3d Frame::bridge_centre() const {
  const BezierTube& last = bridge.back();
  return bridge.size() % 2 == 0 ? bridge[bridge.size() / 2].CentreLine(0.0) : last.CentreLine(0.5);
}
Vector3d Frame::rim_centre_right() const { return {0.5 * design.rim_spacing(), 0.0, 0.0}; }
Vector3d Frame::rim_centre_left() const { return {-0.5 * design.rim_spacing(), 0.0, 0.0}; }

Vector3d BridgeCentre(const FrameDesign& design) {
  const Rim rim = MakeRim(design);
  const std::vector<BezierTube> bridge = MakeBridge(design, BridgeRoot(design, rim));
  return bridge.size() == 1 ? bridge[0].CentreLine(0.5) : bridge[1].CentreLine(0.0);
}

FrameAdjustment StandardAdjustment(const FrameDesign& d) {
  const Rim rim = MakeRim(d);
  const Vector3d corner = TempleCorner(d, TempleRoot(d, rim));
  const double behind = d.parameters.arm_segment() + kStraightArmShare * d.parameters.width + d.details.end_piece;
  FrameAdjustment adjustment;
  adjustment.temple_right.ear = {corner.x(), corner.y() - behind, TempleZ(d) - 0.5 * EarHeight(d)};
  adjustment.temple_left.ear = MirroredX(adjustment.temple_right.ear);
  adjustment.pad_right = StandardPad(d, rim);
  adjustment.pad_left = MirroredX(adjustment.pad_right);
  return adjustment;
}

Result<Frame> BuildFrame(const FrameDesign& design, const FrameAdjustment& adjustment) {
  RETURN_IF_ERROR(Validate(design));
  const Rim rim = MakeRim(design);
  // The left side is built as a right one and mirrored.
  const PadPose pad_left = MirroredX(adjustment.pad_left);
  RETURN_IF_ERROR(CheckPad(design, rim, adjustment.pad_right, "right"));
  RETURN_IF_ERROR(CheckPad(design, rim, pad_left, "left"));
  TempleShape shape_left = adjustment.temple_left;
  shape_left.ear = MirroredX(shape_left.ear);
  const TubeSection root = TempleRoot(design, rim);
  const Result<FrameArm> right = MakeArm(design, root, adjustment.temple_right, "right");
  if (!right) return Fail(right);
  const Result<FrameArm> left = MakeArm(design, root, shape_left, "left");
  if (!left) return Fail(left);
  const std::vector<BezierTube> tubes = RimTubes(rim);
  const BezierPatch lens = RightLens(design, rim);
  std::vector<BezierTube> bridge = MakeBridge(design, BridgeRoot(design, rim));
  std::vector<FrameBody> bodies =
      AssembleBodies({design, rim, bridge, {*right, adjustment.pad_right}, {*left, pad_left}});
  return Frame{design,
               adjustment,
               rim,
               tubes,
               MirroredX(tubes),
               std::move(bridge),
               *right,
               MirroredX(*left),
               lens,
               lens.MirroredX(),
               std::move(bodies)};
}

const std::vector<FrameBody>& FrameBodies(const Frame& frame) { return frame.bodies; }

LensOutline LensOutlineOf(const Frame& frame, Eye eye) {
  const Eigen::Isometry3d rim_from_frame = frame.rim.frame_from_rim.inverse();
  LensOutline outline;
  outline.points.reserve(std::size_t{4} * kOutlineSteps);
  for (std::size_t k = 0; k < 4; ++k) {
    const BezierCurve curve = LensCurve(frame.rim, k);
    for (int step = 0; step < kOutlineSteps; ++step) {
      const Vector3d p = rim_from_frame * CubicBezierPoint(curve, static_cast<double>(step) / kOutlineSteps);
      // Front view: the wearer's left is on the viewer's right.
      outline.points.emplace_back(-p.x(), p.z());
    }
  }
  // The right rim runs M0 (upper outer), M3 (upper inner), …: clockwise seen from the front.
  std::reverse(outline.points.begin(), outline.points.end());
  return eye == Eye::kRight ? outline : Mirrored(outline);
}

std::vector<FrameMesh> TessellateFrameParts(const Frame& frame, const ShellTessellation& tessellation) {
  std::vector<FrameMesh> meshes;
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      meshes.push_back({shell.name, Tessellate(shell, tessellation)});
    }
  }
  return meshes;
}

TriangleMesh TessellateFrame(const Frame& frame, const ShellTessellation& tessellation) {
  TriangleMesh whole;
  for (const FrameMesh& part : TessellateFrameParts(frame, tessellation)) Append(whole, part.mesh);
  return whole;
}

std::vector<FrameMesh> TessellateLenses(const Frame& frame, std::size_t steps) {
  return {{"lens_right", Tessellate(frame.lens_right, steps, steps)},
          {"lens_left", Tessellate(frame.lens_left, steps, steps)}};
}

}  // namespace annulus
