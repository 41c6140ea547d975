#pragma once

#include <array>
#include <optional>

#include "base/result.h"
#include "modeling/glasses/front_pose.h"
#include "modeling/glasses/wearer_head.h"

namespace annulus {

/// A nose pad laid on a flank.
struct PadFit {
  PadPose pose;           ///< Frame frame.
  double moved = 0.0;     ///< mm from where the design has it.
  double distance = 0.0;  ///< mm, least distance of the pad to the skin.
};

/// Lays adjustable pads on both flanks: flat on the mean slope under the pad, touching, as near to their usual place
/// as that allows. Empty where the design has no adjustable pads.
[[nodiscard]] Result<std::optional<std::array<PadFit, 2>>> FitPads(const WearerHead& head, const FrameDesign& design,
                                                                   const Eigen::Isometry3d& station_from_frame);

}  // namespace annulus
