#pragma once

#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/glasses/rim.h"

namespace annulus {

/// u on a side's tube where the centre line is at height z; the nearer end where it does not get there.
[[nodiscard]] double RimParameterAt(const Rim& rim, RimSide side, double z);

/// The rim's centre line on a side at height z (the nearer end of the side where it does not get there).
[[nodiscard]] Eigen::Vector3d CentreLineAt(const Rim& rim, RimSide side, double z);
/// z of the side's centre line at u.
[[nodiscard]] double SideZ(const Rim& rim, RimSide side, double u);

/// The curve along a side's tube on which hidden ends lie, in the rim's plane: between the groove's bottom and the
/// outer seam; without a groove the centre line.
[[nodiscard]] BezierCurve HiddenCurve(const Rim& rim, RimSide side);

/// The section about height z, at most `width` high, in which something ends inside the rim's solid (§3.5): its seams
/// lie on the HiddenCurve, its depth is 0.9 of the rim's there. It is lower than `width` where the side is too curved
/// or too short to hide it.
[[nodiscard]] TubeSection HiddenEnd(const Rim& rim, RimSide side, double z, double width);

}  // namespace annulus
