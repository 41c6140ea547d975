#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acquisition/drift_history.h"
#include "acquisition/scan.h"
#include "base/result.h"
#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

/// The ring's drift history as the store keeps it (setting "drift_history"); empty if there is none yet.
[[nodiscard]] Result<DriftHistory> KeptDriftHistory(Store& store);

/// Starts a job that takes up to twenty scans into the history that it does not hold yet, oldest first (`annulus
/// drift`); scans of targets are left out. Such jobs run one after another, each on the history that the one before has
/// left. Gives the job's id; nothing if there is nothing new. For the technician's page, and for whoever ends a scan
/// (`owner` "": the program itself; how it ended is in DriftAnswer).
[[nodiscard]] Result<std::optional<std::string>> StartDriftUpdate(ConsoleContext& context, const std::string& owner);

/// GET /api/technician/drift: the trend of every sensor over the newest scans, alarms, the last check with a reference,
/// and how the last update ended.
[[nodiscard]] Result<nlohmann::ordered_json> DriftAnswer(ConsoleContext& context);

/// GET /api/technician/sensors: how each sensor did in the newest scan that has a recording, and its drift.
[[nodiscard]] Result<nlohmann::ordered_json> SensorsAnswer(ConsoleContext& context);

}  // namespace annulus
