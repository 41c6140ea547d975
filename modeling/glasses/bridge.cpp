#include "modeling/glasses/bridge.h"

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

/// How far a bowed bridge leans back in the middle: the ridge of a nose runs forward and down.
constexpr double kLean = RadiansFromDegrees(25.0);
/// A saddle's middle is this much higher than d1, for a broad bearing surface.
constexpr double kSaddleHeight = 1.25;
/// How much a keyhole's arch rises at its ends, beside a parabola's tangent.
constexpr double kKeyholeSteepness = 0.8;
/// A keyhole's flanks: length down the rim and how far they swell to the nose, mm.
constexpr double kFlankLength = 12.0;
constexpr double kFlankSwell = 3.0;

Vector3d Mirrored(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

TubeSection Mirrored(const TubeSection& section) {
  return {Mirrored(section.centre), Mirrored(section.half_width), Mirrored(section.half_depth)};
}

std::vector<BezierTube> StraightBridge(const FrameDesign& d, const TubeSection& right) {
  const TubeSection left = Mirrored(right);
  const auto between = [&](double share) -> TubeSection {
    return {(1.0 - share) * right.centre + share * left.centre, Vector3d(0.0, 0.0, 0.5 * d.parameters.upper_thickness),
            Vector3d(0.0, 0.5 * d.depth(), 0.0)};
  };
  return {BezierTube({right, between(1.0 / 3.0), between(2.0 / 3.0), left})};
}

std::vector<BezierTube> BowedBridge(const FrameDesign& d, const TubeSection& right) {
  const double height = d.parameters.upper_thickness * (d.details.bridge == BridgeForm::kSaddle ? kSaddleHeight : 1.0);
  const Vector3d across = -Vector3d::UnitX();
  const Vector3d middle(0.0, right.centre.y() + BridgeForward(d.details), right.centre.z() + BridgeRise(d.details));
  const Vector3d chord = (middle - right.centre).normalized();
  // A parabola's tangents at both ends of a chord are mirror images about it.
  Vector3d leaving = 2.0 * chord.dot(across) * chord - across;
  // A keyhole's hole is rounder: the arch rises from the flanks.
  if (d.details.bridge == BridgeForm::kKeyhole)
    leaving = (leaving + kKeyholeSteepness * Vector3d::UnitZ()).normalized();
  const TubeJet start{right.centre, leaving, right.half_width, right.half_depth};
  const TubeJet end{middle, across, 0.5 * height * Vector3d(0.0, -std::sin(kLean), std::cos(kLean)),
                    0.5 * d.depth() * Vector3d(0.0, std::cos(kLean), std::sin(kLean))};
  BezierTube::Sections half = HermiteTube(start, end).sections();
  // The end section is thinner than the bridge; outside the rim it has its full size at once.
  half[1].half_width = 0.5 * height * right.half_width.normalized();
  half[1].half_depth = 0.5 * d.depth() * right.half_depth.normalized();
  BezierTube::Sections other;
  for (std::size_t i = 0; i < 4; ++i) other[i] = Mirrored(half[3 - i]);
  return {BezierTube(half), BezierTube(other)};
}

}  // namespace

double BridgeForward(const FrameDetails& details) {
  switch (details.bridge) {
    case BridgeForm::kStraight:
      return 0.0;
    case BridgeForm::kSaddle:
      return details.bridge_forward.value_or(2.5);
    case BridgeForm::kKeyhole:
      return details.bridge_forward.value_or(1.0);
  }
  return 0.0;
}

double BridgeRise(const FrameDetails& details) {
  switch (details.bridge) {
    case BridgeForm::kStraight:
      return 0.0;
    case BridgeForm::kSaddle:
      return details.bridge_rise.value_or(1.5);
    case BridgeForm::kKeyhole:
      return details.bridge_rise.value_or(3.0);
  }
  return 0.0;
}

std::vector<BezierTube> MakeBridge(const FrameDesign& design, const TubeSection& right_end) {
  return design.details.bridge == BridgeForm::kStraight ? StraightBridge(design, right_end)
                                                        : BowedBridge(design, right_end);
}

double FlankBottom(const FrameDesign& design, const Rim& rim) {
  const double lowest = SideZ(rim, RimSide::kNose, 1.0);
  return std::max(lowest, BridgeZ(design) - kFlankLength);
}

PatchShell KeyholeFlank(const FrameDesign& design, const Rim& rim) {
  const BezierCurve curve = HiddenCurve(rim, RimSide::kNose);
  const double from = RimParameterAt(rim, RimSide::kNose, BridgeZ(design));
  const double to = std::min(0.999, RimParameterAt(rim, RimSide::kNose, FlankBottom(design, rim)));
  BezierCurve seam = Split(Split(curve, to).first, from / to).second;
  if (rim.bent) {
    // The cubic through the bend at four even places.
    const auto at = [&](int third) -> Vector3d { return RimBend(rim, 1, from + third / 3.0 * (to - from)); };
    seam[0] += at(0);
    seam[1] += (-5.0 * at(0) + 18.0 * at(1) - 9.0 * at(2) + 2.0 * at(3)) / 6.0;
    seam[2] += (2.0 * at(0) - 9.0 * at(1) + 18.0 * at(2) - 5.0 * at(3)) / 6.0;
    seam[3] += at(3);
  }
  // From the centre line to the nose: over half the rim and out of it; the section reaches 3/4 of its control points.
  const double skin = 0.5 * std::max(rim.thickness[3], rim.thickness[6]);
  // Narrow bridges keep half their opening.
  const double opening = design.bridge_gap() - 2.0 * skin;
  const double reach = (skin + std::clamp(0.25 * opening, 0.1, kFlankSwell)) / 0.75;
  const Vector3d nasal = -rim.frame_from_rim.linear().col(0);
  const auto section = [&](std::size_t i, double size) -> TubeSection {
    return {seam[i] + 0.5 * size * reach * nasal, 0.5 * size * reach * nasal, size * rim.half_depth};
  };
  return ShellOfTubes("flank", {BezierTube({section(0, 0.0), section(1, 1.2), section(2, 0.8), section(3, 0.0)})},
                      TubeEnds::kCapped);
}

}  // namespace annulus
