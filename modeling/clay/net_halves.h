#pragma once

#include <array>

#include "modeling/bezier/bezier_patch.h"

namespace annulus {

/// The quarters of a net at u = v = 1/2 by de Casteljau, in the order of its corners (0, 0), (1, 0), (1, 1), (0, 1).
/// Nets that share an edge have quarters that share its halves, to the bit, whichever way their edges run.
[[nodiscard]] std::array<BezierPatch::ControlNet, 4> QuarterNets(const BezierPatch::ControlNet& net);

/// The net whose quarters these would be, made of the four points at each of its corners: the inverse of QuarterNets.
[[nodiscard]] BezierPatch::ControlNet WholeNet(const std::array<BezierPatch::ControlNet, 4>& quarters);

/// The largest distance between control points of the same place, mm.
[[nodiscard]] double LargestDistance(const std::array<BezierPatch::ControlNet, 4>& a,
                                     const std::array<BezierPatch::ControlNet, 4>& b);

}  // namespace annulus
