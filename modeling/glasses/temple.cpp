#include "modeling/glasses/temple.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"
#include "modeling/glasses/hinge.h"
#include "modeling/glasses/rim.h"
#include "modeling/glasses/rimless_mount.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Part R bends by 45° (fig. 16), half of it at each of its two inner control sections.
constexpr double kEarBend = kPi / 4.0;
/// Shortest l6, in units of l7: below, the joint's section would have to turn over to stay smooth.
constexpr double kShortestArm = 6.0;
/// Between a hinged temple and the rim's outer edge, mm.
constexpr double kBesideRim = 0.5;
/// Bends of the tip where the design gives none.
constexpr double kSkullDrop = RadiansFromDegrees(45.0);
constexpr double kStraightDrop = RadiansFromDegrees(5.0);
/// The bend takes this share of the tip, at most this length, mm.
constexpr double kBendShare = 0.4;
constexpr double kLongestBend = 15.0;
/// Height of a tip's end over that at the ear.
constexpr double kSkullWidening = 1.6;
constexpr double kStraightWidening = 1.25;

/// A place of a temple and its directions: unit vectors back along it, up and outward.
struct ArmAxis {
  Vector3d origin;
  Vector3d back;
  Vector3d up;
  Vector3d outward;

  [[nodiscard]] ArmAxis At(double along) const { return {origin + along * back, back, up, outward}; }
};

/// Turned about `up` by an angle that moves `back` outward.
ArmAxis TurnedOutward(const ArmAxis& axis, double angle) {
  return {axis.origin, std::cos(angle) * axis.back + std::sin(angle) * axis.outward, axis.up,
          std::cos(angle) * axis.outward - std::sin(angle) * axis.back};
}

/// Turned about `outward` by an angle that moves `back` down.
ArmAxis TurnedDown(const ArmAxis& axis, double angle) {
  return {axis.origin, std::cos(angle) * axis.back - std::sin(angle) * axis.up,
          std::cos(angle) * axis.up + std::sin(angle) * axis.back, axis.outward};
}

/// The straight stretch from `origin` to the joint at the ear.
struct Aim {
  ArmAxis axis;
  double length = 0.0;
};

/// From `origin` so that the lower seam of a section `height` high meets `ear`.
Aim AimAtEar(const Vector3d& origin, const Vector3d& ear, double height) {
  const Vector3d to_ear = ear - origin;
  const double distance = to_ear.norm();
  const Vector3d towards = to_ear / distance;
  const Vector3d upright = (Vector3d::UnitZ() - towards.z() * towards).normalized();
  // Right triangle: hypotenuse to the ear, one leg the axis, the other half the height down from the axis to the seam.
  const double sine = 0.5 * height / distance;
  const double cosine = std::sqrt(1.0 - sine * sine);
  const Vector3d back = cosine * towards + sine * upright;
  const Vector3d up = -sine * towards + cosine * upright;
  return {{origin, back, up, up.cross(back)}, distance * cosine};
}

TubeSection SectionAt(const ArmAxis& axis, double height, double depth) {
  return {axis.origin, 0.5 * height * axis.up, 0.5 * depth * axis.outward};
}

/// For chains that run forward.
TubeJet JetAt(const ArmAxis& axis, double height, double depth) {
  return {axis.origin, -axis.back, 0.5 * height * axis.up, 0.5 * depth * axis.outward};
}

/// R behind the joint (fig. 16), rows from the tip forward; its heights change by `slope` per mm at the joint.
BezierTube PaperEarPart(const FrameDesign& d, const ArmAxis& joint, double slope) {
  const double s = d.depth();
  const double d1 = d.arm_width();
  const double segment = d.parameters.arm_segment();
  const ArmAxis row2 = joint.At(segment);
  const ArmAxis row1{row2.origin + segment * TurnedDown(joint, 0.5 * kEarBend).back, joint.back, joint.up,
                     joint.outward};
  const ArmAxis row0{row1.origin + segment * TurnedDown(joint, kEarBend).back, joint.back, joint.up, joint.outward};
  // The paper gives row 2 the height s. Where F tapers towards the joint, going on at the same slope makes it G1.
  return BezierTube({SectionAt(TurnedDown(row0, kEarBend), d1, s), SectionAt(TurnedDown(row1, 0.75 * kEarBend), s, s),
                     SectionAt(row2, s - slope * segment, s), SectionAt(joint, s, s)});
}

/// Tip, bend and round end behind the joint, from the end forward.
std::vector<BezierTube> TipChain(const FrameDesign& d, const ArmAxis& joint, double tip_in) {
  const FrameDetails& details = d.details;
  const bool skull = details.temple == TempleForm::kSkull;
  const double drop = details.tip_drop > 0.0 ? details.tip_drop : (skull ? kSkullDrop : kStraightDrop);
  const double height = EarHeight(d);
  const double end_height = height * (skull ? kSkullWidening : kStraightWidening);
  const double s = d.depth();
  const double bend = std::min(kBendShare * details.tip_length, kLongestBend);
  const double round = std::min(0.5 * end_height, 0.2 * details.tip_length);
  ArmAxis tip = TurnedOutward(TurnedDown(joint, drop), -tip_in);
  tip.origin = joint.origin + 0.5 * bend * (joint.back + tip.back);
  const ArmAxis end = tip.At(details.tip_length - bend - round);
  const TubeJet end_jet = JetAt(end, end_height, s);
  const TubeJet tip_jet = JetAt(tip, height, s);
  return {RoundStart(end_jet, round), HermiteTube(end_jet, tip_jet), HermiteTube(tip_jet, JetAt(joint, height, s))};
}

/// The paper's temple: F and R, the whole from the rim to the tip in two tubes.
FrameArm PaperArm(const FrameDesign& d, const TubeSection& root, const Vector3d& corner, const Vector3d& ear) {
  const double s = d.depth();
  const double d1 = d.arm_width();
  const double l5 = d.parameters.arm_segment();
  const Aim aim = AimAtEar(corner, ear, s);
  const double l6 = aim.length - l5;
  const ArmAxis joint = aim.axis.At(aim.length);
  const BezierTube f(
      {SectionAt(joint, s, s),
       SectionAt(aim.axis.At(l5), d1, s),
       {corner, 0.5 * d1 * Mitre(Vector3d::UnitZ(), aim.axis.up), 0.5 * s * Mitre(Vector3d::UnitY(), aim.axis.outward)},
       root});
  FrameArm arm;
  arm.temple = {PaperEarPart(d, joint, (d1 - s) / l6), f};
  arm.l6 = l6;
  arm.length_to_bend = aim.length;
  return arm;
}

/// The corner between rim and hinge (or the straight stretch): one tube, from behind forward.
BezierTube CornerTube(const FrameDesign& d, const TubeSection& root, const Vector3d& corner, const ArmAxis& start) {
  const double s = d.depth();
  const double height = d.arm_width();
  const double reach = 0.5 * (corner - start.origin).norm();
  return BezierTube({SectionAt(start, height, s),
                     SectionAt(start.At(-reach), height, s),
                     {corner, 0.5 * height * Mitre(Vector3d::UnitZ(), start.up),
                      0.5 * s * Mitre(root.half_depth.normalized(), start.outward)},
                     root});
}

/// Every other temple: corner, side piece with its bow, tip.
FrameArm FreeArm(const FrameDesign& d, const TubeSection& root, const Vector3d& corner, const TempleShape& shape) {
  const bool hinged = d.details.hinge != HingeForm::kNone;
  const double s = d.depth();
  const double height = EarHeight(d);
  const double to_hinge = hinged ? d.details.end_piece : d.parameters.arm_segment();
  const Vector3d hinge = corner - to_hinge * Vector3d::UnitY();
  const Aim aim = AimAtEar(hinge, shape.ear, height);
  const ArmAxis start = TurnedOutward(aim.axis, shape.bow);
  const ArmAxis joint = TurnedOutward(aim.axis.At(aim.length), -shape.bow);
  const ArmAxis front = start.At(hinged ? 0.5 * kHingeGap : 0.0);
  FrameArm arm;
  if (d.details.temple == TempleForm::kPaper) {
    arm.temple = {PaperEarPart(d, joint, 0.0)};
  } else {
    arm.temple = TipChain(d, joint, shape.tip_in);
  }
  arm.ear_tube = arm.temple.size() - 1;
  arm.temple.push_back(HermiteTube(JetAt(joint, height, s), JetAt(front, d.arm_width(), s)));
  if (hinged) {
    arm.end_piece = {CornerTube(d, root, corner, start.At(-0.5 * kHingeGap))};
    arm.hinge = PlaceHinge(d, {hinge, start.up, start.back, start.outward, 0.0});
  } else {
    arm.temple.push_back(CornerTube(d, root, corner, start));
  }
  arm.l6 = aim.length;
  arm.length_to_bend = aim.length;
  return arm;
}

void MeasureLengths(FrameArm& arm) {
  const auto length = [](const BezierTube& tube) {
    const BezierTube::Sections& s = tube.sections();
    return CubicBezierLength({s[0].centre, s[1].centre, s[2].centre, s[3].centre});
  };
  // The paper's F holds the corner too: its straight length is what an optician measures.
  if (arm.temple.size() > 2) arm.length_to_bend = length(arm.temple[arm.ear_tube + 1]);
  arm.overall_length = arm.length_to_bend;
  for (std::size_t k = 0; k <= arm.ear_tube; ++k) arm.overall_length += length(arm.temple[k]);
}

Vector3d MirroredX(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

}  // namespace

Vector3d TempleCorner(const FrameDesign& design, const TubeSection& root) {
  double sideways = design.parameters.arm_segment();
  if (design.details.hinge != HingeForm::kNone) {
    // A temple of its own must pass the rim (or lens) whatever its slope.
    const double thickest = std::max(design.parameters.upper_thickness, design.parameters.lower_thickness);
    // Beside a rimless mount the hinge must fit too.
    const double beside =
        design.details.rim == RimForm::kRimless ? kMountRadius + kKnuckleClearance + kKnuckleDiameter : 0.5 * thickest;
    sideways = std::max(sideways, beside + 0.375 * design.depth() + kBesideRim);
  }
  return root.centre + Vector3d(sideways, 0.0, 0.0);
}

double EarHeight(const FrameDesign& d) {
  return d.details.temple == TempleForm::kPaper ? d.depth() : std::max(d.depth(), 0.5 * d.arm_width());
}

Result<FrameArm> MakeArm(const FrameDesign& d, const TubeSection& root, const TempleShape& shape,
                         const char* side_name) {
  const Vector3d corner = TempleCorner(d, root);
  const double nearest = d.parameters.arm_segment() * (1.0 + kShortestArm) + d.details.end_piece;
  const double behind = corner.y() - shape.ear.y();
  if (!shape.ear.allFinite() || !(behind > nearest) || !((shape.ear - corner).norm() < 1.2 * behind)) {
    return Fail(
        fmt::format("build the {} temple", side_name),
        fmt::format("the ear point is {:.1f} mm behind and {:.1f} mm away from the hinge", behind,
                    (shape.ear - corner).norm()),
        fmt::format("check the ear point: it must be more than {:.1f} mm behind, not far to the side", nearest));
  }
  constexpr double kLargestTurn = RadiansFromDegrees(45.0);
  if (!(std::abs(shape.bow) <= 0.5 * kLargestTurn) || !(std::abs(shape.tip_in) <= kLargestTurn)) {
    return Fail(fmt::format("bend the {} temple", side_name),
                fmt::format("bow is {:.1f} and tip-in {:.1f} degrees", DegreesFromRadians(shape.bow),
                            DegreesFromRadians(shape.tip_in)),
                "choose a bow from -22.5 to 22.5 degrees and a tip-in from -45 to 45 degrees");
  }
  const bool paper = d.details.temple == TempleForm::kPaper && d.details.hinge == HingeForm::kNone && shape.bow == 0.0;
  FrameArm arm = paper ? PaperArm(d, root, corner, shape.ear) : FreeArm(d, root, corner, shape);
  const TubeSection& joint = arm.temple[arm.ear_tube].sections()[3];
  arm.ear_point = joint.centre - joint.half_width;
  MeasureLengths(arm);
  return arm;
}

FrameArm MirroredX(const FrameArm& arm) {
  FrameArm mirrored = arm;
  mirrored.end_piece = MirroredX(arm.end_piece);
  mirrored.temple = MirroredX(arm.temple);
  mirrored.ear_point = MirroredX(arm.ear_point);
  if (mirrored.hinge) {
    for (Vector3d HingeAxis::*member : {&HingeAxis::point, &HingeAxis::up, &HingeAxis::back, &HingeAxis::outward}) {
      (*mirrored.hinge).*member = MirroredX((*mirrored.hinge).*member);
    }
  }
  return mirrored;
}

}  // namespace annulus
