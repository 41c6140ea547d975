#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/console/console_context.h"

namespace annulus {

/// What `annulus calibrate --json` printed as the page shows it: {passed, verdict, limits: [{name, unit, as_found,
/// as_left, limit, passed}], findings, unobservable, budget, certificate, placements, plots}.
[[nodiscard]] nlohmann::ordered_json CalibrationResultJson(const nlohmann::ordered_json& printed);

/// Takes a solved calibration into the store, with its report, and puts it in force: it replaces the file
/// (CalibrationPath) that boothd reads when it arms. `folder` has CAL.json and report/, `result` is what the page was
/// shown. Gives its name; fails, with nothing in force changed, if the store or that file cannot be written.
[[nodiscard]] Result<std::string> KeepCalibration(ConsoleContext& context, const std::string& folder,
                                                  const nlohmann::ordered_json& result);

/// {name, made_ms, verdict, sigma_common_mm, …} of the calibration in force, or null.
[[nodiscard]] nlohmann::ordered_json CalibrationInForceJson(ConsoleContext& context);
/// The calibrations of the store, newest first.
[[nodiscard]] Result<nlohmann::ordered_json> CalibrationHistoryJson(Store& store);

/// A file of a stored calibration's report: "report.html", "report.pdf", "CAL.json", or "data.json": what was shown of
/// its result.
[[nodiscard]] Result<std::vector<std::byte>> StoredCalibrationFile(Store& store, const std::string& name,
                                                                   const std::string& file);

}  // namespace annulus
