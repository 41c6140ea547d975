#pragma once

#include <Eigen/Core>
#include <vector>

#include "modeling/bezier/bezier_tube.h"

namespace annulus {

/// A tube's section at a joint and how it changes along the tube: two tubes that share a jet join with G1.
struct TubeJet {
  Eigen::Vector3d centre;
  Eigen::Vector3d tangent;  ///< Unit, the way the tube runs.
  Eigen::Vector3d half_width;
  Eigen::Vector3d half_depth;
  Eigen::Vector3d half_width_change{0.0, 0.0, 0.0};  ///< Per mm along the tangent.
};

/// The tube from `start` to `end` that leaves and arrives along their tangents; the inner control sections stand
/// `reach_start` and `reach_end` (mm, > 0) from the ends. A third of the distance gives an even run.
[[nodiscard]] BezierTube HermiteTube(const TubeJet& start, const TubeJet& end, double reach_start, double reach_end);
/// The same with a third of the distance between the ends as both reaches.
[[nodiscard]] BezierTube HermiteTube(const TubeJet& start, const TubeJet& end);

/// A round end that begins in a pole, `length` mm behind `end`, and joins a tube that starts with `end` with G1: a
/// quarter of an ellipse along the tube. Requires length > 0 and no change of the width at `end`.
[[nodiscard]] BezierTube RoundStart(const TubeJet& end, double length);

/// The chain mirrored at the plane x = 0, its tubes and their rows in the same order.
[[nodiscard]] std::vector<BezierTube> MirroredX(const std::vector<BezierTube>& chain);

/// The chain that runs through the same solid the other way: last tube first, rows turned round; A and B change sides.
[[nodiscard]] std::vector<BezierTube> Reversed(const std::vector<BezierTube>& chain);

/// The largest angle between the surfaces of neighbouring tubes at their joins, rad: between the normals and between
/// the directions along the tube of both patches, at 9 places of each seam-to-seam curve.
[[nodiscard]] double LargestKink(const std::vector<BezierTube>& chain);

}  // namespace annulus
