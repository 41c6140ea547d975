#include "modeling/glasses/front_shape.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Rims nearer to the middle than half the gap and this share of their width may bear on the nose.
constexpr double kNasalShare = 0.35;
/// A bearing on one flank is at least this far from the frame's middle, mm.
constexpr double kOffMiddle = 0.5;
/// What rims and bridge keep from the nose where pads carry the front, mm.
constexpr double kBesidePads = 0.3;

void AddLens(const LensPlane& lens, double back, double clearance, std::vector<FrontPoint>& points) {
  for (const double share : {0.0, 0.4, 0.75, 0.98}) {
    for (std::size_t k = 0; k < lens.outline.size(); k += share == 0.0 ? lens.outline.size() : 4) {
      const Eigen::Vector2d at = share * lens.outline[k];
      points.push_back({lens.centre + at.x() * lens.right + at.y() * lens.up - back * lens.forward, clearance});
    }
  }
}

}  // namespace

bool MayBear(const FrameDesign& design, FrameRole role, const Vector3d& p) {
  if (std::abs(p.x()) < kOffMiddle) return false;
  if (design.details.pads != PadForm::kNone) return role == FrameRole::kPad;
  return std::abs(p.x()) < 0.5 * design.bridge_gap() + kNasalShare * design.parameters.width;
}

Result<FrontShape> MakeFrontShape(const FrameDesign& design, const FitGoals& goals,
                                  const std::array<double, 2>& lens_back, const PointDensity& density) {
  const FrameAdjustment usual = StandardAdjustment(design);
  const auto shells = FrontShells(design, usual);
  RETURN_IF_ERROR(shells);
  FrontShape front;
  front.design = design;
  front.bearing = design.details.pads == PadForm::kAdjustable ? NoseBearing::kAdjust : NoseBearing::kRigid;
  front.pads = {usual.pad_right.centre, usual.pad_left.centre};
  const double nasal = 0.5 * design.bridge_gap() + kNasalShare * design.parameters.width;
  front.hinges = {Vector3d(-1e9, 0.0, 0.0), Vector3d(1e9, 0.0, 0.0)};
  for (const FrameShell& part : *shells) {
    const bool is_pad = part.role == FrameRole::kPad || part.role == FrameRole::kPadArm;
    if (is_pad && front.bearing == NoseBearing::kAdjust) continue;  // they go where the flank is
    for (const Vector3d& p : SamplePoints(part.shell, density)) {
      const bool may_bear = MayBear(design, part.role, p);
      const bool is_nasal = std::abs(p.x()) < nasal;
      const double clearance = may_bear ? 0.0 : is_nasal ? kBesidePads : goals.skin_clearance;
      if (may_bear) {
        front.bearing_points[p.x() > 0.0 ? 0 : 1].push_back(front.points.size());
      }
      front.points.push_back({p, clearance});
      if (p.x() > front.hinges[0].x()) front.hinges[0] = p;
      if (p.x() < front.hinges[1].x()) front.hinges[1] = p;
    }
  }
  const Rim rim = MakeRim(design);
  front.lenses = {LensPlaneOf(rim, Eye::kRight), LensPlaneOf(rim, Eye::kLeft)};
  for (std::size_t side = 0; side < 2; ++side) {
    AddLens(front.lenses[side], lens_back[side], goals.lens_clearance, front.points);
  }
  return front;
}

}  // namespace annulus
