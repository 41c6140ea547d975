#pragma once

#include <vector>

#include "modeling/glasses/lens_thickness.h"

namespace annulus {

/// Where along the edge the bevel's apex runs.
enum class BevelMode {
  kFrontFollow,  ///< A fixed distance behind the front edge.
  kRatio,        ///< A fixed share of the edge behind the front edge: 0.5 is 50/50.
  kCurve,        ///< On a sphere of a given curve (0: flat) about the box centre, as far forward as the edge allows.
};
struct BevelRule {
  BevelMode mode = BevelMode::kRatio;
  double front_distance = 1.0;  ///< kFrontFollow: mm; 0.3…20.
  double ratio = 0.5;           ///< kRatio: 0.1…0.9.
  double curve = 4.0;           ///< kCurve: D of a tool of index 1.53, 0…12: radius 530 / curve mm.
  double width = 1.4;           ///< Foot of the bevel, mm; 0.5…5: half of it should lie on each side of the apex.
};

/// The bevel along the edge; one value for each point of the LensEdge.
struct LensBevel {
  std::vector<double> apex_z;   ///< Lens frame, mm.
  double mean_z = 0.0;          ///< mm: lies in the plane of the rim's groove when the lens is inserted.
  double unevenness = 0.0;      ///< Largest distance of the apex from its mean plane z = mean_z, mm.
  double smallest_front = 0.0;  ///< Least distance from the apex to the front edge, mm; negative: off the edge.
  double smallest_back = 0.0;   ///< To the back edge.
};
/// The apex along `edge` (points and z in the lens frame), `box_centre` for kCurve. Whether it fits is in the smallest
/// distances: both should be at least half the width.
[[nodiscard]] LensBevel BevelOf(const LensEdge& edge, const Eigen::Vector2d& box_centre, const BevelRule& rule);

}  // namespace annulus
