#include "modeling/glasses/nose_pad.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"
#include "modeling/glasses/hidden_end.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kSplay = RadiansFromDegrees(30.0);
constexpr double kFrontal = RadiansFromDegrees(25.0);
/// The edge of a pad bulges this much over its outline, mm (the control points; the surface 3/4 of it).
constexpr double kEdgeBulge = 0.8;
/// Handles of a wire's curve, as a share of the distance that it bridges.
constexpr double kWireReach = 0.7;
/// Distance of the inner control points of a quarter circle from its ends, in radii.
const double kQuarter = 4.0 / 3.0 * (std::sqrt(2.0) - 1.0);

/// The oval of a face in quarters: up → front → down → back.
using Oval = std::array<BezierCurve, 4>;

/// Semi-axes as vectors; `round` is the quarters' handle length: kQuarter an ellipse, larger is squarer.
Oval MakeOval(const Vector3d& centre, const Vector3d& up, const Vector3d& front, double round) {
  const std::array<Vector3d, 4> axis{up, front, -up, -front};
  Oval oval;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d& from = axis[k];
    const Vector3d& to = axis[(k + 1) % 4];
    oval[k] = {centre + from, centre + from + round * to, centre + to + round * from, centre + to};
  }
  return oval;
}

BezierPatch FaceOver(const Oval& oval, const Vector3d& raised) {
  const BezierPatch flat = CoonsPatch({oval[0], Backwards(oval[2]), Backwards(oval[3]), oval[1]});
  BezierPatch::ControlNet net = flat.control_net();
  for (std::size_t i = 1; i < 3; ++i) {
    for (std::size_t j = 1; j < 3; ++j) net[i][j] += raised;
  }
  return BezierPatch(net);
}

/// A solid between two ovals: faces over both and four sides through two control ovals between.
PatchShell Loft(std::string name, const std::array<Oval, 4>& ovals, const Vector3d& raised) {
  PatchShell shell{std::move(name), {}};
  shell.patches.push_back({FaceOver(ovals[0], raised), PatchDetail::kAround, PatchDetail::kAround});
  const BezierPatch back = FaceOver(ovals[3], Vector3d::Zero()).Flipped();
  shell.patches.push_back({back, PatchDetail::kAround, PatchDetail::kAround});
  for (std::size_t k = 0; k < 4; ++k) {
    shell.patches.push_back({BezierPatch({ovals[0][k], ovals[1][k], ovals[2][k], ovals[3][k]}).Flipped(),
                             PatchDetail::kAround, PatchDetail::kAround});
  }
  return TurnedOutward(shell);
}

/// A tube's end section as an oval: halves A and B cut in their middles; up, front, down, back.
Oval SectionOval(const TubeSection& section) {
  const auto half = [&section](double side) -> BezierCurve {
    const Vector3d& up = section.half_width;
    const Vector3d depth = side * section.half_depth;
    return {section.centre + up, section.centre + up + depth, section.centre - up + depth, section.centre - up};
  };
  const auto front = Split(half(1.0), 0.5);
  const auto back = Split(half(-1.0), 0.5);
  return {front.first, front.second, Backwards(back.second), Backwards(back.first)};
}

Oval Shifted(const Oval& oval, const Vector3d& by) {
  Oval shifted = oval;
  for (BezierCurve& quarter : shifted) {
    for (Vector3d& point : quarter) point += by;
  }
  return shifted;
}

/// The pad's axes with lengths: half its length up, half its width towards the front; without the edge's bulge.
struct PadAxes {
  Vector3d up;
  Vector3d front;
};

PadAxes AxesOf(const FrameDesign& d, const Rim& rim, const PadPose& pose, double bulge) {
  Vector3d front = pose.normal.cross(pose.up);
  if (front.dot(rim.frame_from_rim.linear().col(1)) < 0.0) front = -front;
  return {(0.5 * d.details.pad_length + bulge) * pose.up, (0.5 * d.details.pad_width + bulge) * front};
}

}  // namespace

PadPose StandardPad(const FrameDesign& d, const Rim& rim) {
  const bool fixed = d.details.pads == PadForm::kFixed;
  const double lowest = SideZ(rim, RimSide::kNose, 0.85);
  const double z = std::max(lowest, BridgeZ(d) - 8.0);
  const Vector3d on_rim = CentreLineAt(rim, RimSide::kNose, z);
  // Fixed pads stand close to the rim's skin, adjustable ones behind it.
  const double skin = 0.5 * std::max(d.parameters.upper_thickness, d.parameters.lower_thickness);
  PadPose pose;
  pose.centre = {std::max(1.5, on_rim.x() - skin - (fixed ? 1.5 : 0.5)), on_rim.y() - (fixed ? 2.0 : 6.0), z};
  const double c = std::cos(kFrontal);
  const double s = std::sin(kFrontal);
  pose.up = {-s, 0.0, c};
  pose.normal = {-c * std::cos(kSplay), -std::sin(kSplay), -s * std::cos(kSplay)};
  return pose;
}

double PadAnchorZ(const FrameDesign& d, const Rim& rim, const PadPose& pose) {
  const double high = std::min(SideZ(rim, RimSide::kNose, 0.05), BridgeZ(d));
  const double low = std::min(high, SideZ(rim, RimSide::kNose, 0.9));
  return std::clamp(pose.centre.z() + (d.details.pads == PadForm::kAdjustable ? 2.0 : 0.0), low, high);
}

PatchShell PadShell(const FrameDesign& d, const Rim& rim, const PadPose& pose) {
  const PadAxes small = AxesOf(d, rim, pose, -0.75 * kEdgeBulge);
  const PadAxes large = AxesOf(d, rim, pose, 0.25 * kEdgeBulge);
  constexpr double kSquareness = 0.66;
  const Vector3d rim_of_face = pose.centre - kPadConvexity * pose.normal;
  const Oval face = MakeOval(rim_of_face, small.up, small.front, kSquareness);
  const Vector3d raised = kPadConvexity * 16.0 / 9.0 * pose.normal;
  if (d.details.pads == PadForm::kFixed) {
    const TubeSection hidden = HiddenEnd(rim, RimSide::kNose, PadAnchorZ(d, rim, pose), 0.5 * d.details.pad_length);
    const Oval root = SectionOval(hidden);
    const Vector3d nasal = -rim.frame_from_rim.linear().col(0);
    const double reach = (hidden.centre - pose.centre).norm() / 3.0;
    const Oval bulged = MakeOval(rim_of_face - std::min(0.8, reach) * pose.normal, large.up, large.front, kSquareness);
    return Loft("pad", {face, bulged, Shifted(root, reach * nasal), root}, raised);
  }
  const Vector3d back = -kPadThickness * pose.normal;
  const Oval bulged = MakeOval(rim_of_face, large.up, large.front, kSquareness);
  return Loft("pad", {face, bulged, Shifted(bulged, back), Shifted(face, back)}, raised);
}

PatchShell PadWire(const PadPose& pose, const Vector3d& anchor, const Vector3d& leaving, double diameter) {
  const Vector3d end = pose.centre - (kPadConvexity + 0.5 * kPadThickness) * pose.normal;
  const double reach = kWireReach * (end - anchor).norm();
  const auto [first, second] = Split({anchor, anchor + reach * leaving, end - reach * pose.normal, end}, 0.5);
  // The section's width stays across the plane in which the wire bends, so that it does not collapse on the way.
  Vector3d across_bend = leaving.cross(end - anchor);
  if (across_bend.norm() < 1e-3 * (end - anchor).norm()) across_bend = Vector3d::UnitZ();
  // About round: the section is 0.75 of its control polygon deep.
  const auto jet = [&](const Vector3d& centre, const Vector3d& tangent) -> TubeJet {
    Vector3d across = across_bend - across_bend.dot(tangent) * tangent;
    if (across.norm() < 1e-3 * across_bend.norm()) across = pose.up - pose.up.dot(tangent) * tangent;
    across.normalize();
    return {centre, tangent, 0.5 * diameter * across, diameter / 1.5 * tangent.cross(across)};
  };
  const TubeJet from = jet(anchor, leaving);
  const TubeJet middle = jet(first[3], (second[1] - first[2]).normalized());
  const TubeJet to = jet(end, pose.normal);
  const auto handle = [](const Vector3d& a, const Vector3d& b) { return (a - b).norm(); };
  return ShellOfTubes("pad_wire",
                      {HermiteTube(from, middle, handle(first[1], first[0]), handle(first[3], first[2])),
                       HermiteTube(middle, to, handle(second[1], second[0]), handle(second[3], second[2]))},
                      TubeEnds::kCapped);
}

double PadWireDiameter(const FrameDesign& d, const Rim& rim) {
  const double thinnest = *std::min_element(rim.thickness.begin(), rim.thickness.end());
  return std::min({1.2, 0.5 * thinnest, 0.6 * d.depth()});
}

}  // namespace annulus
