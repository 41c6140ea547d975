#pragma once

#include <Eigen/Core>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/clay/cubic.h"

namespace annulus {

/// Signed volume of the cone between a patch and an apex O, mm³ (paper 004, fig. 3, eqs. 1–6): (1/3)∬(R − O)·(R_u ×
/// R_v) du dv, the sign under the integral, since N·R may change it inside a patch. Positive where the normal R_u × R_v
/// looks away from the apex. The integrand has degree 8 in u and v; five Gauss nodes each way make it exact up to
/// rounding.
[[nodiscard]] double ConeVolume(const BezierPatch::ControlNet& net, const Eigen::Vector3d& apex);

/// The same for the control points `net` + k·`direction` as a polynomial of k: the volume is trilinear in the control
/// points.
[[nodiscard]] Cubic ConeVolumeAlong(const BezierPatch::ControlNet& net, const BezierPatch::ControlNet& direction,
                                    const Eigen::Vector3d& apex);

/// Area of a patch, mm², by the same 25 nodes: exact for a plane patch with straight parameter lines, else to about
/// 1e-6 where the patch bends by less than 30°.
[[nodiscard]] double PatchArea(const BezierPatch::ControlNet& net);

}  // namespace annulus
