#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acquisition/scan.h"
#include "base/progress.h"
#include "base/result.h"
#include "modeling/measure/breath.h"
#include "render/image.h"

namespace annulus {

/// Breathing in a scan whose ring stood still. Fails as MeasureBreath.
[[nodiscard]] Result<BreathMeasures> BreathOfScan(const Scan& scan, const TaskContext& task);

/// The object `breath` (docs/formats.md).
[[nodiscard]] nlohmann::ordered_json JsonFromBreath(const BreathMeasures& breath);

/// The same in a few lines for people, intervals of 95 %.
[[nodiscard]] std::string TextFromBreath(const BreathMeasures& breath);

/// The girth over the whole time and over the mean breath, side by side. Fails as RenderXyPlot.
[[nodiscard]] Result<RgbImage> DrawBreath(const BreathMeasures& breath);

}  // namespace annulus
