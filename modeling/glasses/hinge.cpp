#include "modeling/glasses/hinge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "modeling/bezier/shell_solids.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kKnuckleRadius = 0.5 * kKnuckleDiameter;
constexpr double kHoleRadius = 0.5 * kHingeHoleDiameter;
/// A leaf starts this far beside the hole's edge and ends this far beyond the knuckle, mm.
constexpr double kLeafToHole = 0.15;
constexpr double kLeafBeyond = 1.6;
constexpr double kSmallestHeight = 2.4;
constexpr double kLargestHeight = 6.0;

/// From the temple's middle plane to the axis.
double AxisOffset(const FrameDesign& d) { return 0.375 * d.depth() + kKnuckleClearance + kKnuckleRadius; }

/// Axis frame: x back, y outward, z up.
Eigen::Isometry3d FrameFromAxis(const HingeAxis& axis, double up) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = axis.back;
  pose.linear().col(1) = axis.outward;
  pose.linear().col(2) = axis.up;
  pose.translation() = axis.point + up * axis.up;
  return pose;
}

PatchShell Knuckle(const HingeAxis& axis, double up, double height) {
  const double half = 0.5 * height;
  return TurnedShell("knuckle", FrameFromAxis(axis, up),
                     {{kHoleRadius, -half}, {kKnuckleRadius, -half}, {kKnuckleRadius, half}, {kHoleRadius, half}},
                     ProfileEnds::kLoop);
}

/// The block from the temple's (end piece's) middle plane past the axis; `side` 1 is the temple's, -1 the front's.
PatchShell Leaf(const FrameDesign& d, const HingeAxis& axis, double up, double height, double side) {
  const double near = kHoleRadius + kLeafToHole;
  const double far = kKnuckleRadius + kLeafBeyond;
  const double inner = -0.4 * kKnuckleRadius;
  const double outer = AxisOffset(d);
  Eigen::Isometry3d pose = FrameFromAxis(axis, up);
  pose.translation() += side * 0.5 * (near + far) * axis.back + 0.5 * (inner + outer) * axis.outward;
  return BoxShell("leaf", pose, {0.5 * (far - near), 0.5 * (outer - inner), 0.5 * height});
}

}  // namespace

HingeAxis PlaceHinge(const FrameDesign& design, const HingeAxis& joint) {
  HingeAxis axis = joint;
  axis.point = joint.point - AxisOffset(design) * joint.outward;
  axis.height = std::clamp(0.9 * design.arm_width(), kSmallestHeight, kLargestHeight);
  return axis;
}

Eigen::Isometry3d ClosedFromOpen(const HingeAxis& axis, double angle) {
  const Eigen::AngleAxisd turn(angle, axis.outward.cross(axis.back).normalized());
  return Eigen::Translation3d(axis.point) * turn * Eigen::Translation3d(-axis.point);
}

HingeShells MakeHinge(const FrameDesign& design, const HingeAxis& axis) {
  const double third = (axis.height - 2.0 * kKnuckleGap) / 3.0;
  HingeShells shells;
  for (const double up : {third + kKnuckleGap, -third - kKnuckleGap}) {
    shells.front.push_back(Knuckle(axis, up, third));
    shells.front.push_back(Leaf(design, axis, up, third, -1.0));
  }
  shells.temple = {Knuckle(axis, 0.0, third), Leaf(design, axis, 0.0, third, 1.0)};
  return shells;
}

}  // namespace annulus
