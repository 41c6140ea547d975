#pragma once

#include <vector>

#include "acquisition/drift_alarm.h"
#include "acquisition/drift_history.h"
#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// The trend of every sensor since the calibration: a map of deviations from the baseline (from zero while there is
/// none; sensors to the right, scans downwards), below it the lines of the sensors that are told, or of the three that
/// have moved most. Fails on a history without scans.
[[nodiscard]] Result<RgbImage> DrawDrift(const DriftHistory& history, const DriftState& state);

}  // namespace annulus
