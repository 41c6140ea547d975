#include "modeling/glasses/frame_assembly.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "modeling/glasses/hidden_end.h"
#include "modeling/glasses/hinge.h"
#include "modeling/glasses/rimless_mount.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A half rim goes on this far below what it holds, mm.
constexpr double kHalfRimMargin = 2.5;

/// The shells of one side, as if it were the right one, by the body that they belong to.
struct SideShells {
  std::vector<PatchShell> nose;    ///< Rim, flank, pad.
  std::vector<PatchShell> hinge;   ///< End piece and its knuckles, or the arm in one piece.
  std::vector<PatchShell> temple;  ///< Empty without a hinge.
};

HalfRimSpan SpanOf(const FrameDesign& d, const Rim& rim, const FrameSide& side) {
  double nose = BridgeZ(d) - BridgeRoot(d, rim).half_width.norm();
  if (d.details.pads != PadForm::kNone)
    nose = std::min(nose, PadAnchorZ(d, rim, side.pad) - 0.25 * d.details.pad_length);
  if (d.details.bridge == BridgeForm::kKeyhole) nose = std::min(nose, FlankBottom(d, rim));
  const double temple = TempleZ(d) - TempleRoot(d, rim).half_width.norm();
  return {std::clamp(RimParameterAt(rim, RimSide::kNose, nose - kHalfRimMargin), 0.05, 0.99),
          std::clamp(RimParameterAt(rim, RimSide::kTemple, temple - kHalfRimMargin), 0.01, 0.95)};
}

void AppendPad(const FrameDesign& d, const Rim& rim, const PadPose& pose, std::vector<PatchShell>& shells) {
  if (d.details.pads == PadForm::kNone) return;
  shells.push_back(PadShell(d, rim, pose));
  if (d.details.pads != PadForm::kAdjustable) return;
  const Vector3d back = -rim.frame_from_rim.linear().col(1);
  if (d.details.rim == RimForm::kRimless) {
    const RimlessMount mount = MakeRimlessMount("", d, rim, RimSide::kNose, BridgeZ(d), d.parameters.upper_thickness);
    const Vector3d in_nut = mount.frame_from_mount * Vector3d(0.0, 0.0, -0.5 * d.details.lens_edge - 0.5);
    shells.push_back(PadWire(pose, in_nut, back, 1.2));
    return;
  }
  const double z = PadAnchorZ(d, rim, pose);
  const TubeSection anchor = HiddenEnd(rim, RimSide::kNose, z, PadWireDiameter(d, rim));
  shells.push_back(PadWire(pose, anchor.centre, back, PadWireDiameter(d, rim)));
}

std::vector<PatchShell> NoseShells(const FramePieces& pieces, const FrameSide& side) {
  const FrameDesign& d = pieces.design;
  std::vector<PatchShell> shells;
  switch (d.details.rim) {
    case RimForm::kFull:
      shells.push_back(RimShell("rim", pieces.rim, std::nullopt));
      break;
    case RimForm::kHalf:
      shells.push_back(RimShell("rim", pieces.rim, SpanOf(d, pieces.rim, side)));
      break;
    case RimForm::kRimless:
      shells.push_back(
          MakeRimlessMount("mount_nose", d, pieces.rim, RimSide::kNose, BridgeZ(d), d.parameters.upper_thickness)
              .shell);
      break;
  }
  if (d.details.bridge == BridgeForm::kKeyhole) shells.push_back(KeyholeFlank(d, pieces.rim));
  AppendPad(d, pieces.rim, side.pad, shells);
  return shells;
}

SideShells ShellsOf(const FramePieces& pieces, const FrameSide& side) {
  const FrameDesign& d = pieces.design;
  SideShells shells{NoseShells(pieces, side), {}, {}};
  if (d.details.rim == RimForm::kRimless) {
    shells.hinge.push_back(
        MakeRimlessMount("mount_temple", d, pieces.rim, RimSide::kTemple, TempleZ(d), d.arm_width()).shell);
  }
  const FrameArm& arm = side.arm;
  if (!arm.hinge) {
    shells.hinge.push_back(ShellOfTubes("arm", arm.temple, TubeEnds::kCapped));
    return shells;
  }
  HingeShells hinge = MakeHinge(d, *arm.hinge);
  shells.hinge.push_back(ShellOfTubes("end_piece", arm.end_piece, TubeEnds::kCapped));
  std::move(hinge.front.begin(), hinge.front.end(), std::back_inserter(shells.hinge));
  shells.temple.push_back(ShellOfTubes("temple", arm.temple, TubeEnds::kCapped));
  std::move(hinge.temple.begin(), hinge.temple.end(), std::back_inserter(shells.temple));
  return shells;
}

void Name(SideShells& shells, const std::string& suffix) {
  for (auto* group : {&shells.nose, &shells.hinge, &shells.temple}) {
    for (PatchShell& shell : *group) shell.name += suffix;
  }
}

void Mirror(SideShells& shells) {
  for (auto* group : {&shells.nose, &shells.hinge, &shells.temple}) {
    for (PatchShell& shell : *group) shell = MirroredX(shell, shell.name);
  }
}

FrameBody Joined(std::string name, std::initializer_list<std::vector<PatchShell>*> groups) {
  FrameBody body{std::move(name), {}};
  for (std::vector<PatchShell>* group : groups) {
    std::move(group->begin(), group->end(), std::back_inserter(body.shells));
  }
  return body;
}

}  // namespace

TubeSection BridgeRoot(const FrameDesign& d, const Rim& rim) {
  const double width = d.parameters.upper_thickness;
  if (d.details.rim != RimForm::kRimless) return HiddenEnd(rim, RimSide::kNose, BridgeZ(d), width);
  return MakeRimlessMount("", d, rim, RimSide::kNose, BridgeZ(d), width).end;
}

TubeSection TempleRoot(const FrameDesign& d, const Rim& rim) {
  if (d.details.rim != RimForm::kRimless) return HiddenEnd(rim, RimSide::kTemple, TempleZ(d), d.arm_width());
  return MakeRimlessMount("", d, rim, RimSide::kTemple, TempleZ(d), d.arm_width()).end;
}

std::vector<FrameBody> AssembleBodies(const FramePieces& pieces) {
  SideShells right = ShellsOf(pieces, pieces.right);
  SideShells left = ShellsOf(pieces, pieces.left);
  Mirror(left);
  Name(right, "_right");
  Name(left, "_left");
  std::vector<PatchShell> bridge{ShellOfTubes("bridge", pieces.bridge, TubeEnds::kCapped)};
  const bool hinged = pieces.right.arm.hinge.has_value();
  std::vector<FrameBody> bodies;
  if (pieces.design.details.rim == RimForm::kRimless) {
    bodies.push_back(Joined("bridge", {&bridge, &right.nose, &left.nose}));
    bodies.push_back(Joined(hinged ? "end_piece_right" : "arm_right", {&right.hinge}));
    bodies.push_back(Joined(hinged ? "end_piece_left" : "arm_left", {&left.hinge}));
  } else {
    bodies.push_back(Joined(hinged ? "front" : "frame", {&right.nose, &left.nose, &bridge, &right.hinge, &left.hinge}));
  }
  if (hinged) {
    bodies.push_back(Joined("temple_right", {&right.temple}));
    bodies.push_back(Joined("temple_left", {&left.temple}));
  }
  return bodies;
}

}  // namespace annulus
