#include "modeling/bezier/tube_chain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Distance of the inner control points of a quarter circle from its ends, in radii.
const double kQuarter = 4.0 / 3.0 * (std::sqrt(2.0) - 1.0);

TubeSection At(const TubeJet& jet, double along) {
  return {jet.centre + along * jet.tangent, jet.half_width + along * jet.half_width_change, jet.half_depth};
}

double Angle(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Kink between the end of `before` and the start of `after`.
double Kink(const BezierPatch& before, const BezierPatch& after) {
  double kink = 0.0;
  for (int step = 0; step <= 8; ++step) {
    const double v = step / 8.0;
    kink = std::max({kink, Angle(before.DerivativeU(1.0, v), after.DerivativeU(0.0, v)),
                     Angle(before.Normal(1.0, v), after.Normal(0.0, v))});
  }
  return kink;
}

}  // namespace

BezierTube HermiteTube(const TubeJet& start, const TubeJet& end, double reach_start, double reach_end) {
  ENSURE(reach_start > 0.0 && reach_end > 0.0, "a tube runs forward");
  return BezierTube({At(start, 0.0), At(start, reach_start), At(end, -reach_end), At(end, 0.0)});
}

BezierTube HermiteTube(const TubeJet& start, const TubeJet& end) {
  const double reach = (end.centre - start.centre).norm() / 3.0;
  return HermiteTube(start, end, reach, reach);
}

BezierTube RoundStart(const TubeJet& end, double length) {
  ENSURE(length > 0.0 && end.half_width_change.isZero(), "a round end has a length and an even section");
  const auto section = [&](double along, double size) -> TubeSection {
    return {end.centre - along * length * end.tangent, size * end.half_width, size * end.half_depth};
  };
  return BezierTube({section(1.0, 0.0), section(1.0, kQuarter), section(kQuarter, 1.0), section(0.0, 1.0)});
}

std::vector<BezierTube> MirroredX(const std::vector<BezierTube>& chain) {
  std::vector<BezierTube> mirrored;
  mirrored.reserve(chain.size());
  for (const BezierTube& tube : chain) mirrored.push_back(tube.MirroredX());
  return mirrored;
}

std::vector<BezierTube> Reversed(const std::vector<BezierTube>& chain) {
  std::vector<BezierTube> reversed;
  reversed.reserve(chain.size());
  for (auto tube = chain.rbegin(); tube != chain.rend(); ++tube) {
    BezierTube::Sections sections = tube->sections();
    std::reverse(sections.begin(), sections.end());
    for (TubeSection& section : sections) section.half_depth = -section.half_depth;
    reversed.emplace_back(sections);
  }
  return reversed;
}

double LargestKink(const std::vector<BezierTube>& chain) {
  double kink = 0.0;
  for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
    kink = std::max({kink, Kink(chain[k].a(), chain[k + 1].a()), Kink(chain[k].b(), chain[k + 1].b())});
  }
  return kink;
}

}  // namespace annulus
