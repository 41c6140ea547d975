#include "modeling/glasses/frame.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Bridge and temples are this much thinner where they end inside the rim, so that their ends stay under its surface.
constexpr double kHiddenEndTaper = 0.9;
/// l6 / l1 of a frame that nobody wears.
constexpr double kStraightArmShare = 1.7;
/// Points of a lens' outline on each of the rim's four tubes.
constexpr int kOutlineSteps = 180;
/// Part R bends by 45° (fig. 16), half of it at each of its two inner control sections.
constexpr double kEarBend = kPi / 4.0;
/// Shortest l6, in units of l7: below, the joint's section would have to turn over to stay smooth.
constexpr double kShortestArm = 6.0;

/// The offset, per unit of distance, of the corner between two lines with these unit normals.
Vector3d Mitre(const Vector3d& a, const Vector3d& b) { return (a + b) / (1.0 + a.dot(b)); }

/// The right rim's centre-line octagon M0 … M11 (fig. 9) and, at each M, the vector to the outer outline.
struct Octagon {
  std::array<Vector3d, 12> m;
  std::array<Vector3d, 12> half_width;
};

/// P1 … P4 (upper outer, upper inner, lower inner, lower outer) of the right rim (fig. 9).
std::array<Vector3d, 4> Rectangle(const FrameDesign& d) {
  const double outer = 0.5 * (d.rim_spacing() + d.parameters.width);
  const double inner = 0.5 * (d.rim_spacing() - d.parameters.width);
  const double top = 0.5 * d.parameters.height;
  return {Vector3d(outer, 0.0, top), Vector3d(inner, 0.0, top), Vector3d(inner, 0.0, -top), Vector3d(outer, 0.0, -top)};
}

Octagon MakeOctagon(const FrameDesign& d) {
  const std::array<Vector3d, 4> corner = Rectangle(d);
  const std::array<double, 4> cut{d.parameters.upper_outer, d.parameters.upper_inner, d.parameters.lower_inner,
                                  d.parameters.lower_outer};  // t0, t3, t6, t9
  const std::array<double, 4> thickness{d.parameters.upper_thickness, d.parameters.upper_thickness,
                                        d.parameters.lower_thickness, d.parameters.lower_thickness};
  // Outward normals of the sides P1P2, P2P3, P3P4, P4P1.
  const std::array<Vector3d, 4> normal{Vector3d::UnitZ(), -Vector3d::UnitX(), -Vector3d::UnitZ(), Vector3d::UnitX()};
  Octagon octagon;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d before = (corner[(k + 3) % 4] - corner[k]).normalized();
    const Vector3d after = (corner[(k + 1) % 4] - corner[k]).normalized();
    const Vector3d& normal_before = normal[(k + 3) % 4];
    const Vector3d& normal_after = normal[k];
    const Vector3d bisector = (normal_before + normal_after).normalized();
    const double half = 0.5 * thickness[k];
    // P_kM ⟂ the cut at 45°: it meets the two sides at √2·t from the corner.
    const double along = std::numbers::sqrt2 * cut[k];
    octagon.m[(3 * k + 11) % 12] = corner[k] + along * before;
    octagon.m[3 * k] = corner[k] - cut[k] * bisector;
    octagon.m[3 * k + 1] = corner[k] + along * after;
    octagon.half_width[(3 * k + 11) % 12] = half * Mitre(normal_before, bisector);
    octagon.half_width[3 * k] = half * bisector;
    octagon.half_width[3 * k + 1] = half * Mitre(bisector, normal_after);
  }
  return octagon;
}

TubeSection RimSection(const FrameDesign& d, const Octagon& octagon, std::size_t k) {
  return {octagon.m[k % 12], octagon.half_width[k % 12], Vector3d(0.0, 0.5 * d.depth(), 0.0)};
}

BezierTube RimTube(const FrameDesign& d, const Octagon& octagon, std::size_t k) {
  return BezierTube({RimSection(d, octagon, 3 * k), RimSection(d, octagon, 3 * k + 1),
                     RimSection(d, octagon, 3 * k + 2), RimSection(d, octagon, 3 * k + 3)});
}

/// §3.6: the boundary control points are the rim's inner ones, the inner four the third points of P1P2P3P4 raised 3s.
BezierPatch LensPatch(const FrameDesign& d, const Octagon& octagon) {
  const auto inner = [&octagon](std::size_t k) -> Vector3d { return octagon.m[k % 12] - octagon.half_width[k % 12]; };
  const std::array<Vector3d, 4> corner = Rectangle(d);
  const Vector3d right = (corner[1] - corner[0]) / 3.0;
  const Vector3d down = (corner[3] - corner[0]) / 3.0;
  const Vector3d raised = corner[0] + Vector3d(0.0, 3.0 * d.depth(), 0.0);
  BezierPatch::ControlNet net;
  net[0] = {inner(0), inner(1), inner(2), inner(3)};
  net[1] = {inner(11), raised + right + down, raised + 2.0 * right + down, inner(4)};
  net[2] = {inner(10), raised + right + 2.0 * down, raised + 2.0 * right + 2.0 * down, inner(5)};
  net[3] = {inner(9), inner(8), inner(7), inner(6)};
  return BezierPatch(net);
}

BezierPatch MirroredPatch(const BezierPatch& patch) {
  BezierPatch::ControlNet net = patch.control_net();
  for (auto& row : net) {
    for (Vector3d& point : row) point.x() = -point.x();
  }
  return BezierPatch(net).Flipped();
}

/// The point of a side tube's centre line at height z. z falls or rises all the way along such a tube.
Vector3d CentreLineAtHeight(const BezierTube& tube, double z) {
  const bool rises = tube.CentreLine(1.0).z() > tube.CentreLine(0.0).z();
  double low = 0.0;
  double high = 1.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    if ((tube.CentreLine(middle).z() < z) == rises) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return tube.CentreLine(0.5 * (low + high));
}

/// z of a height over P3P4.
double OverLowerEdge(const FrameDesign& d, double height) { return height - 0.5 * d.parameters.height; }
double BridgeZ(const FrameDesign& d) { return OverLowerEdge(d, d.parameters.bridge_height); }
double TempleZ(const FrameDesign& d) { return OverLowerEdge(d, d.arm_height()); }

/// The section, `width` high about `z`, in which a bridge or temple ends inside the rim: its seams lie on the rim's
/// centre line (§3.5).
TubeSection HiddenEnd(const FrameDesign& d, const BezierTube& side, double z, double width) {
  const Vector3d top = CentreLineAtHeight(side, z + 0.5 * width);
  const Vector3d bottom = CentreLineAtHeight(side, z - 0.5 * width);
  return {0.5 * (top + bottom), 0.5 * (top - bottom), Vector3d(0.0, 0.5 * kHiddenEndTaper * d.depth(), 0.0)};
}

BezierTube MakeBridge(const FrameDesign& d, const BezierTube& nose_side) {
  const TubeSection right = HiddenEnd(d, nose_side, BridgeZ(d), d.parameters.upper_thickness);
  TubeSection left = right;
  left.centre.x() = -right.centre.x();
  left.half_width.x() = -right.half_width.x();
  const auto between = [&](double share) -> TubeSection {
    return {(1.0 - share) * right.centre + share * left.centre, Vector3d(0.0, 0.0, 0.5 * d.parameters.upper_thickness),
            Vector3d(0.0, 0.5 * d.depth(), 0.0)};
  };
  return BezierTube({right, between(1.0 / 3.0), between(2.0 / 3.0), left});
}

/// The straight stretch of a temple: unit vectors back to the ear, up and outward, and its length from the hinge.
struct ArmAxis {
  Vector3d back;
  Vector3d up;
  Vector3d outward;
  double length;
};

/// From the hinge (row 2 of F) so that the lower seam of a section s high meets `ear`.
ArmAxis AimAtEar(const Vector3d& hinge, const Vector3d& ear, double s) {
  const Vector3d to_ear = ear - hinge;
  const double distance = to_ear.norm();
  const Vector3d towards = to_ear / distance;
  const Vector3d upright = (Vector3d::UnitZ() - towards.z() * towards).normalized();
  // Right triangle: hypotenuse to the ear, one leg the axis, the other s/2 down from the axis to the lower seam.
  const double sine = 0.5 * s / distance;
  const double cosine = std::sqrt(1.0 - sine * sine);
  ArmAxis axis;
  axis.back = cosine * towards + sine * upright;
  axis.up = -sine * towards + cosine * upright;
  axis.outward = axis.up.cross(axis.back);
  axis.length = distance * cosine;
  return axis;
}

/// R behind the joint at `joint` (fig. 16), rows from the tip forward.
BezierTube MakeEarPart(const FrameDesign& d, const ArmAxis& axis, const Vector3d& joint, double l6) {
  const double s = d.depth();
  const double d1 = d.arm_width();
  const double l7 = d.parameters.arm_segment();
  const auto back = [&axis](double bend) -> Vector3d { return std::cos(bend) * axis.back - std::sin(bend) * axis.up; };
  const auto up = [&axis](double bend) -> Vector3d { return std::cos(bend) * axis.up + std::sin(bend) * axis.back; };
  const Vector3d half_depth = 0.5 * s * axis.outward;
  const Vector3d row2 = joint + l7 * axis.back;
  const Vector3d row1 = row2 + d.parameters.arm_segment() * back(0.5 * kEarBend);
  const Vector3d row0 = row1 + d.parameters.arm_segment() * back(kEarBend);
  // The paper gives row 2 the height s. F tapers from d1 to s towards the joint; going on at the same slope makes it
  // G1.
  const double height2 = s - (d1 - s) * l7 / l6;
  return BezierTube({{{row0, 0.5 * d1 * up(kEarBend), half_depth},
                      {row1, 0.5 * s * up(0.75 * kEarBend), half_depth},
                      {row2, 0.5 * height2 * axis.up, half_depth},
                      {joint, 0.5 * s * axis.up, half_depth}}});
}

/// The right temple. F leaves the rim along +x, turns by about 90° at its row 2 and runs to the ear.
Result<FrameArm> MakeArm(const FrameDesign& d, const BezierTube& temple_side, const Vector3d& ear,
                         const char* side_name) {
  const TubeSection row3 = HiddenEnd(d, temple_side, TempleZ(d), d.arm_width());
  const Vector3d hinge = row3.centre + Vector3d(d.parameters.arm_segment(), 0.0, 0.0);
  const double nearest = d.parameters.arm_segment() * (1.0 + kShortestArm);
  const double behind = hinge.y() - ear.y();
  if (!ear.allFinite() || !(behind > nearest) || !((ear - hinge).norm() < 1.2 * behind)) {
    return Fail(
        fmt::format("build the {} temple", side_name),
        fmt::format("the ear point is {:.1f} mm behind and {:.1f} mm away from the hinge", behind,
                    (ear - hinge).norm()),
        fmt::format("check the ear point: it must be more than {:.1f} mm behind, not far to the side", nearest));
  }
  const double s = d.depth();
  const double d1 = d.arm_width();
  const ArmAxis axis = AimAtEar(hinge, ear, s);
  const double l5 = d.parameters.arm_segment();
  const double l6 = axis.length - l5;
  const Vector3d joint = hinge + axis.length * axis.back;
  const Vector3d forward = Vector3d::UnitY();
  const Vector3d half_depth = 0.5 * s * axis.outward;
  const BezierTube f({{{joint, 0.5 * s * axis.up, half_depth},
                       {hinge + l5 * axis.back, 0.5 * d1 * axis.up, half_depth},
                       {hinge, 0.5 * d1 * Mitre(Vector3d::UnitZ(), axis.up), 0.5 * s * Mitre(forward, axis.outward)},
                       row3}});
  return FrameArm{f, MakeEarPart(d, axis, joint, l6), l6, joint - 0.5 * s * axis.up};
}

Vector3d MirroredX(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

FrameArm MirroredArm(const FrameArm& arm) {
  return {arm.f.MirroredX(), arm.r.MirroredX(), arm.l6, MirroredX(arm.ear_point)};
}

}  // namespace

Vector3d Frame::bridge_centre() const { return {0.0, 0.0, BridgeZ(design)}; }
Vector3d Frame::rim_centre_right() const { return {0.5 * design.rim_spacing(), 0.0, 0.0}; }
Vector3d Frame::rim_centre_left() const { return {-0.5 * design.rim_spacing(), 0.0, 0.0}; }

FrameAdjustment StandardAdjustment(const FrameDesign& d) {
  const BezierTube temple_side = RimTube(d, MakeOctagon(d), 3);
  const double x = HiddenEnd(d, temple_side, TempleZ(d), d.arm_width()).centre.x() + d.parameters.arm_segment();
  const double y = -(d.parameters.arm_segment() + kStraightArmShare * d.parameters.width);
  FrameAdjustment adjustment;
  adjustment.temple_right.ear = {x, y, TempleZ(d) - 0.5 * d.depth()};
  adjustment.temple_left.ear = MirroredX(adjustment.temple_right.ear);
  return adjustment;
}

Result<Frame> BuildFrame(const FrameDesign& design, const FrameAdjustment& adjustment) {
  RETURN_IF_ERROR(Validate(design));
  const Octagon octagon = MakeOctagon(design);
  const std::array<BezierTube, 4> rim{RimTube(design, octagon, 0), RimTube(design, octagon, 1),
                                      RimTube(design, octagon, 2), RimTube(design, octagon, 3)};
  const Result<FrameArm> right = MakeArm(design, rim[3], adjustment.temple_right.ear, "right");
  RETURN_IF_ERROR(right);
  const Result<FrameArm> left = MakeArm(design, rim[3], MirroredX(adjustment.temple_left.ear), "left");
  RETURN_IF_ERROR(left);
  const BezierPatch lens = LensPatch(design, octagon);
  return Frame{design,
               adjustment,
               rim,
               {rim[0].MirroredX(), rim[1].MirroredX(), rim[2].MirroredX(), rim[3].MirroredX()},
               MakeBridge(design, rim[1]),
               *right,
               MirroredArm(*left),
               lens,
               MirroredPatch(lens)};
}

std::vector<FramePart> FrameParts(const Frame& frame) {
  return {{"rim_right", {frame.rim_right.begin(), frame.rim_right.end()}, TubeEnds::kLoop},
          {"rim_left", {frame.rim_left.begin(), frame.rim_left.end()}, TubeEnds::kLoop},
          {"bridge", {frame.bridge}, TubeEnds::kCapped},
          {"arm_right", {frame.arm_right.r, frame.arm_right.f}, TubeEnds::kCapped},
          {"arm_left", {frame.arm_left.r, frame.arm_left.f}, TubeEnds::kCapped}};
}

std::vector<FrameBody> FrameBodies(const Frame& frame) {
  FrameBody body{"frame", {}};
  for (const FramePart& part : FrameParts(frame)) {
    body.shells.push_back(ShellOfTubes(part.name, part.tubes, part.ends));
  }
  return {body};
}

LensOutline LensOutlineOf(const Frame& frame, Eye eye) {
  const auto& rim = eye == Eye::kRight ? frame.rim_right : frame.rim_left;
  const Vector3d centre = eye == Eye::kRight ? frame.rim_centre_right() : frame.rim_centre_left();
  LensOutline outline;
  for (const BezierTube& tube : rim) {
    for (int step = 0; step < kOutlineSteps; ++step) {
      const Vector3d p = tube.Point(static_cast<double>(step) / kOutlineSteps, 0.0) - centre;
      // Front view: the wearer's left is on the viewer's right.
      outline.points.emplace_back(-p.x(), p.z());
    }
  }
  // The right rim runs M0 (upper outer), M3 (upper inner), …: clockwise seen from the front; its mirror image does not.
  if (eye == Eye::kRight) std::reverse(outline.points.begin(), outline.points.end());
  return outline;
}

std::vector<FrameMesh> TessellateFrameParts(const Frame& frame, const TubeTessellation& tessellation) {
  std::vector<FrameMesh> meshes;
  for (const FramePart& part : FrameParts(frame)) {
    meshes.push_back({part.name, TessellateChain(part.tubes, part.ends, tessellation)});
  }
  return meshes;
}

TriangleMesh TessellateFrame(const Frame& frame, const TubeTessellation& tessellation) {
  TriangleMesh whole;
  for (const FrameMesh& part : TessellateFrameParts(frame, tessellation)) Append(whole, part.mesh);
  return whole;
}

std::vector<FrameMesh> TessellateLenses(const Frame& frame, std::size_t steps) {
  return {{"lens_right", Tessellate(frame.lens_right, steps, steps)},
          {"lens_left", Tessellate(frame.lens_left, steps, steps)}};
}

}  // namespace annulus
