#include "modeling/glasses/hidden_end.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;

std::size_t TubeOf(RimSide side) { return side == RimSide::kNose ? 1 : 3; }

/// The side's first and last section; those between have the thickness of one of the two.
std::size_t Start(RimSide side) { return 3 * TubeOf(side); }
std::size_t End(RimSide side) { return (3 * TubeOf(side) + 3) % 12; }

double CurveParameterAt(const BezierCurve& curve, double z) {
  const bool rises = curve[3].z() > curve[0].z();
  double low = 0.0;
  double high = 1.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    ((CubicBezierPoint(curve, middle).z() < z) == rises ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// What a hidden end may wander off its curve, in half widths.
constexpr double kWander = 0.3;

/// Of the half thickness, how far a rim may bend away from a hidden end.
constexpr double kBend = 0.2;

/// The point of a curve of a side at height z, with the bend.
Vector3d BentPoint(const Rim& rim, RimSide side, const BezierCurve& curve, double z) {
  const double u = CurveParameterAt(curve, z);
  return CubicBezierPoint(curve, u) + RimBend(rim, TubeOf(side), u);
}

/// How far a curve in the rim leaves a chord of it: in the rim's plane in half widths, along its normal in half
/// thicknesses.
struct Bulge {
  double in_plane = 0.0;
  double out_of_plane = 0.0;
};

Bulge BulgeOver(const Rim& rim, RimSide side, const BezierCurve& curve, const Vector3d& top, const Vector3d& bottom) {
  const double thinnest = std::min(rim.thickness[Start(side)], rim.thickness[End(side)]);
  const double half_thickness = 0.75 * rim.half_depth.norm();
  const Vector3d normal = rim.half_depth.normalized();
  const double height = std::max((top - bottom).norm(), 1e-12);
  Bulge bulge;
  for (const double share : {0.25, 0.5, 0.75}) {
    const Vector3d chord = (1.0 - share) * top + share * bottom;
    const Vector3d on_curve = BentPoint(rim, side, curve, chord.z());
    const Vector3d sag = on_curve - chord;
    const double in_plane = (sag - sag.dot(normal) * normal).norm();
    // Beside its centre line a bent rim has the height of another place along it.
    const double steepness =
        std::max(std::abs((on_curve - top).dot(normal)), std::abs((on_curve - bottom).dot(normal)));
    bulge.in_plane = std::max(bulge.in_plane, in_plane / (0.5 * thinnest));
    bulge.out_of_plane =
        std::max(bulge.out_of_plane, (std::abs(sag.dot(normal)) + in_plane * steepness / height) / half_thickness);
  }
  return bulge;
}

/// Place of the HiddenCurve, in half widths.
double HiddenPlace(const Rim& rim, RimSide side) {
  if (rim.groove_v <= 0.0) return 0.0;
  const double deepest = std::max(rim.lens_place[Start(side)], rim.lens_place[End(side)]);
  return std::max(0.0, deepest + kWander + 0.1);
}

}  // namespace

double RimParameterAt(const Rim& rim, RimSide side, double z) {
  return CurveParameterAt(RimCurve(rim, TubeOf(side), 0.0), z);
}

Vector3d CentreLineAt(const Rim& rim, RimSide side, double z) {
  return BentPoint(rim, side, RimCurve(rim, TubeOf(side), 0.0), z);
}

double SideZ(const Rim& rim, RimSide side, double u) {
  return CubicBezierPoint(RimCurve(rim, TubeOf(side), 0.0), u).z();
}

BezierCurve HiddenCurve(const Rim& rim, RimSide side) { return RimCurve(rim, TubeOf(side), HiddenPlace(rim, side)); }

TubeSection HiddenEnd(const Rim& rim, RimSide side, double z, double width) {
  constexpr double kTaper = 0.9;
  const BezierCurve curve = HiddenCurve(rim, side);
  const double room = std::min(std::abs(z - curve[0].z()), std::abs(z - curve[3].z()));
  double height = std::min(width, 1.9 * room);
  Vector3d top;
  Vector3d bottom;
  Bulge bulge;
  for (int round = 0; round < 12; ++round) {
    top = BentPoint(rim, side, curve, z + 0.5 * height);
    bottom = BentPoint(rim, side, curve, z - 0.5 * height);
    bulge = BulgeOver(rim, side, curve, top, bottom);
    const double excess = std::max(bulge.in_plane / kWander, bulge.out_of_plane / kBend);
    if (excess <= 1.0) break;
    height *= 0.95 / std::sqrt(excess);
  }
  const double place = HiddenPlace(rim, side);
  const double share = place > 0.0 ? RimDepthShare(std::min(place + kWander, 0.95)) / 0.75 : 1.0;
  const double taper = kTaper - 1.25 * bulge.out_of_plane;
  return {0.5 * (top + bottom), 0.5 * (top - bottom), taper * share * rim.half_depth};
}

}  // namespace annulus
