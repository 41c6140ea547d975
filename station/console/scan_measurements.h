#pragma once

#include <nlohmann/json_fwd.hpp>

#include "modeling/table/table.h"
#include "station/console/model_cache.h"
#include "station/sheet_words.h"

namespace annulus {

/// The table as it is kept with a scan: as `annulus measure --json`, every line with its name in Japanese (`term_ja`)
/// and where it lies on the body (`curve`: one polyline of [x, y, z] in mm, to 0.1; `curves` if there are several).
[[nodiscard]] nlohmann::ordered_json KeptMeasurements(const MeasurementTable& table);
/// The same for a reader of one language: `term` is in it.
[[nodiscard]] nlohmann::ordered_json MeasurementsIn(nlohmann::ordered_json kept, SheetLanguage language);
/// `landmarks` of docs/console_api.md §7: those of the model, then those that were not found.
[[nodiscard]] nlohmann::ordered_json LandmarksForPage(const OpenModel& model);

}  // namespace annulus
