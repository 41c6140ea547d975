#pragma once

#include <Eigen/Geometry>
#include <string>

#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/rim.h"

namespace annulus {

/// Diameter of the holes in a rimless lens, mm.
inline constexpr double kLensHoleDiameter = 1.4;

/// Radius of a mount's disc, its largest, mm.
inline constexpr double kMountRadius = 2.0;

/// What holds a rimless lens on one side: a disc before and a nut behind the lens on a screw through its hole.
struct RimlessMount {
  Eigen::Isometry3d frame_from_mount;  ///< Origin in the middle of the lens' edge thickness, z the rim's normal.
  TubeSection end;                     ///< In which bridge or end piece ends, inside the front disc.
  PatchShell shell;                    ///< Disc, screw and nut.
};

/// The mount of the right lens about height z; the hole is 3 mm inside the lens' outline (less on small lenses).
[[nodiscard]] RimlessMount MakeRimlessMount(std::string name, const FrameDesign& design, const Rim& rim, RimSide side,
                                            double z, double width);

}  // namespace annulus
