#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_stroke.h"

namespace annulus {

/// Where it is smoothed: in full within half the radius of `centre`, less to its edge.
struct SmoothSpot {
  ClayAddress at;
  Eigen::Vector3d centre;
  double radius_mm = 1.0;
};

/// Moves every linked group in the spots by `amount` (0 … 1) of the way to the mean of the groups next to it, and turns
/// it so that its edges point to where those then are; what that takes from the volume, all of the spots give back
/// along their normals.
Result<ClayChange> SmoothOnce(ClayBody& body, const std::vector<SmoothSpot>& spots, double amount,
                              const MaskWeight& mask);

}  // namespace annulus
