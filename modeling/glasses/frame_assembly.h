#pragma once

#include <vector>

#include "modeling/bezier/bezier_tube.h"
#include "modeling/glasses/bridge.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/nose_pad.h"
#include "modeling/glasses/rim.h"
#include "modeling/glasses/temple.h"

namespace annulus {

/// The section in which the bridge starts on the right, the temple or end piece on the right: hidden in the rim, or in
/// the mount of a rimless lens.
[[nodiscard]] TubeSection BridgeRoot(const FrameDesign& design, const Rim& rim);
[[nodiscard]] TubeSection TempleRoot(const FrameDesign& design, const Rim& rim);

/// What is particular to one side, as if it were the right one.
struct FrameSide {
  FrameArm arm;
  PadPose pad;
};

/// The pieces that FrameBodies joins.
struct FramePieces {
  const FrameDesign& design;
  const Rim& rim;
  const std::vector<BezierTube>& bridge;
  FrameSide right;
  FrameSide left;  ///< Mirrored at x = 0.
};

/// The bodies (see FrameBodies) of a frame whose design and adjustment have been checked.
[[nodiscard]] std::vector<FrameBody> AssembleBodies(const FramePieces& pieces);

}  // namespace annulus
