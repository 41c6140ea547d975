#pragma once

#include <string>
#include <vector>

#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/rim.h"

namespace annulus {

/// How far the pads' touching face swells over its outline, mm.
inline constexpr double kPadConvexity = 0.4;
/// Thickness of an adjustable pad from its outline's plane to its back, mm.
inline constexpr double kPadThickness = 1.6;

/// The right pad's pose on a frame that nobody wears: splay 30°, frontal angle 25°, between rim and nose under the
/// bridge. For a frame without pads too (where its rims would rest).
[[nodiscard]] PadPose StandardPad(const FrameDesign& design, const Rim& rim);

/// z at which a pad's wire or neck leaves the rim's nose side, mm.
[[nodiscard]] double PadAnchorZ(const FrameDesign& design, const Rim& rim, const PadPose& pose);

/// The right side's pad: the pad alone when adjustable, with the neck that ends inside the rim's nose side when fixed.
/// pose.centre is on the touching face.
[[nodiscard]] PatchShell PadShell(const FrameDesign& design, const Rim& rim, const PadPose& pose);

/// The wire of the right adjustable pad, from `anchor` (inside the rim or mount), leaving along `leaving`, to the
/// middle of the pad.
[[nodiscard]] PatchShell PadWire(const PadPose& pose, const Eigen::Vector3d& anchor, const Eigen::Vector3d& leaving,
                                 double diameter);

/// Diameter of a pad's wire: 1.2 mm, less where the rim is too thin to hide its end.
[[nodiscard]] double PadWireDiameter(const FrameDesign& design, const Rim& rim);

}  // namespace annulus
