#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/temple.h"

namespace annulus {

// A three-barrel hinge: two knuckles on the end piece, one between them on the temple, all on the temple's inner side.
// mm.
inline constexpr double kPinDiameter = 1.0;
inline constexpr double kHingeHoleDiameter = 1.2;  ///< Leaves the pin a clearance of 0.1.
inline constexpr double kKnuckleDiameter = 2.6;
inline constexpr double kKnuckleGap = 0.12;  ///< Between neighbouring knuckles along the axis.
/// Between a knuckle and the other side's inner face: a temple swings freely from open to 90°; further open, the faces
/// meet.
inline constexpr double kKnuckleClearance = 0.25;

/// The axis for a joint whose `point` is the middle of the temple's section at the gap: inside the temple by half its
/// thickness, the clearance and half a knuckle; the height of the three knuckles from the temple's width.
[[nodiscard]] HingeAxis PlaceHinge(const FrameDesign& design, const HingeAxis& joint);

/// How a temple's points move when it closes by `angle` (rad, 0 open, up to 90°).
[[nodiscard]] Eigen::Isometry3d ClosedFromOpen(const HingeAxis& axis, double angle);

/// The hinge's shells of one side: knuckles and the leaves that hold them.
struct HingeShells {
  std::vector<PatchShell> front;
  std::vector<PatchShell> temple;
};
[[nodiscard]] HingeShells MakeHinge(const FrameDesign& design, const HingeAxis& axis);

}  // namespace annulus
