#pragma once

#include <string>

#include "base/calibration_target.h"
#include "base/result.h"

namespace annulus {

/// A calibration target as the command line names it: `cylinder`, `sphere`, `plane` or `step`, a colon, and key=value
/// pairs with commas between them:
///
///     cylinder:radius_mm=150,u_mm=0.02,serial=C-17,certificate=K-4711
///     step:radius_mm=100,u_mm=0.01,step_mm=10,edges_mm=100;300;500
///
/// Keys: radius_mm and u_mm (the radius' expanded uncertainty, k = 2), which all but planes need; step_mm and edges_mm,
/// which steps need; serial, certificate, certified_c, expansion_per_c, height_mm, width_mm (planes). Fails on an
/// unknown, repeated or missing key and on a value that makes no sense, naming it.
[[nodiscard]] Result<CalibrationTarget> ParseTarget(const std::string& text);

}  // namespace annulus
