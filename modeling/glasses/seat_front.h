#pragma once

#include <array>

#include "base/result.h"
#include "modeling/glasses/frame_skin.h"
#include "modeling/glasses/front_pose.h"

namespace annulus {

/// A front that bears.
struct SeatedFront {
  FrontPose pose;
  std::array<SkinPlace, 2> bearing;  ///< Least distance on the right and left flank; of adjustable pads: far.
  double least = 0.0;                ///< mm, least distance of everything else.
};

/// Moves a front by little so that nothing enters and, where bridge, rims or fixed pads carry it, both flanks are
/// touched: by the true distances, least motion first. `front` must be the front of `design`.
[[nodiscard]] Result<SeatedFront> SeatFront(const WearerHead& head, const FrontShape& front, const FrontPose& pose);

}  // namespace annulus
