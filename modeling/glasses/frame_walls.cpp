#include "modeling/glasses/frame_walls.h"

#include <algorithm>
#include <array>
#include <limits>

#include "modeling/glasses/hinge.h"
#include "modeling/glasses/nose_pad.h"
#include "modeling/glasses/rimless_mount.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr int kSteps = 48;

double At(int step) { return static_cast<double>(step) / kSteps; }

/// Smallest distance from a curve to another that runs beside it.
double Between(const BezierCurve& inner, const BezierCurve& outer) {
  std::array<Vector3d, kSteps + 1> points;
  for (int k = 0; k <= kSteps; ++k) points[static_cast<std::size_t>(k)] = CubicBezierPoint(outer, At(k));
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= kSteps; ++k) {
    const Vector3d p = CubicBezierPoint(inner, At(k));
    for (std::size_t j = 0; j + 1 < points.size(); ++j) {
      const Vector3d along = points[j + 1] - points[j];
      const double share = std::clamp((p - points[j]).dot(along) / std::max(along.squaredNorm(), 1e-18), 0.0, 1.0);
      smallest = std::min(smallest, (p - points[j] - share * along).norm());
    }
  }
  return smallest;
}

/// The thinner direction of a tube's sections between two places.
double ThinnestSection(const BezierTube& tube, double from, double to) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= kSteps; ++k) {
    const double u = from + (to - from) * At(k);
    thinnest = std::min({thinnest, (tube.Point(u, 0.25) - tube.Point(u, 0.75)).norm(),
                         (tube.Point(u, 0.0) - tube.Point(u, 0.5)).norm()});
  }
  return thinnest;
}

/// Of a chain; `hidden` is the share of the first (and last) tube inside the rim. Round ends are left out.
struct HiddenShares {
  double first = 0.0;
  double last = 0.0;
};
double ThinnestOf(const std::vector<BezierTube>& chain, const HiddenShares& hidden) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < chain.size(); ++k) {
    if (chain[k].sections()[0].half_width.isZero()) continue;
    thinnest = std::min(thinnest, ThinnestSection(chain[k], k == 0 ? hidden.first : 0.0,
                                                  k + 1 == chain.size() ? 1.0 - hidden.last : 1.0));
  }
  return thinnest;
}

void AppendRim(const Frame& frame, std::vector<Wall>& walls) {
  const std::array<const char*, 4> names{"rim_top", "rim_nose", "rim_bottom", "rim_temple"};
  const bool half = frame.design.details.rim == RimForm::kHalf;
  for (std::size_t k = 0; k < 4; ++k) {
    if (half && k == 2) continue;
    walls.push_back({names[k], Between(LensCurve(frame.rim, k), RimCurve(frame.rim, k, 1.0))});
  }
  walls.push_back({"rim_depth", (frame.rim_right[0].Point(0.5, 0.25) - frame.rim_right[0].Point(0.5, 0.75)).norm()});
}

/// Half way from the lips to the bottom, from the flank straight to the rim's front.
void AppendShoulder(const Frame& frame, std::vector<Wall>& walls) {
  const Rim& rim = frame.rim;
  if (rim.groove_v <= 0.0) return;
  const double width = frame.design.details.groove_width;
  const double lip = GrooveLip(width / frame.design.depth());
  double thinnest = std::numeric_limits<double>::infinity();
  for (const std::size_t i : {std::size_t{0}, std::size_t{6}}) {  // d1, d2
    const double place = 0.5 * (lip + rim.lens_place[i]);
    thinnest = std::min(thinnest, rim.half_depth.norm() * RimDepthShare(place) - 0.25 * width);
  }
  walls.push_back({"groove_shoulder", thinnest});
}

}  // namespace

std::vector<Wall> WallsOf(const Frame& frame) {
  std::vector<Wall> walls;
  const FrameDetails& details = frame.design.details;
  if (details.rim != RimForm::kRimless) {
    AppendRim(frame, walls);
    AppendShoulder(frame, walls);
  } else {
    walls.push_back({"lens_screw", kLensHoleDiameter - 0.1});
  }
  constexpr double kHidden = 0.15;
  walls.push_back({"bridge", ThinnestOf(frame.bridge, {kHidden, kHidden})});
  const double in_rim = frame.arm_right.hinge ? 0.0 : kHidden;
  walls.push_back({"temple", std::min(ThinnestOf(frame.arm_right.temple, {0.0, in_rim}),
                                      ThinnestOf(frame.arm_left.temple, {0.0, in_rim}))});
  if (frame.arm_right.hinge) {
    walls.push_back({"end_piece", std::min(ThinnestOf(frame.arm_right.end_piece, {0.0, kHidden}),
                                           ThinnestOf(frame.arm_left.end_piece, {0.0, kHidden}))});
    walls.push_back({"knuckle", 0.5 * (kKnuckleDiameter - kHingeHoleDiameter)});
    walls.push_back({"leaf", (frame.arm_right.hinge->height - 2.0 * kKnuckleGap) / 3.0});
  }
  if (details.pads != PadForm::kNone) walls.push_back({"pad", kPadThickness});
  if (details.pads == PadForm::kAdjustable) walls.push_back({"pad_wire", PadWireDiameter(frame.design, frame.rim)});
  return walls;
}

}  // namespace annulus
