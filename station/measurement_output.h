#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "modeling/measure/table.h"

namespace annulus {

/// A number for JSON: null where it is not finite.
[[nodiscard]] nlohmann::ordered_json JsonNumber(double value);

/// Half width of the two-sided 95 % interval of a normal error; NaN where sigma is.
[[nodiscard]] double HalfWidth95(const Uncertain& value);

/// Whether the 95 % interval is within the class limit; nothing where there is no limit or no sigma.
[[nodiscard]] std::optional<bool> IntervalWithinLimit(const Measurement& measurement);

/// The table with the keys of DESIGN.md §3 (`measurements` of {id, term, definition, value_mm, sigma_mm, low95_mm,
/// high95_mm, measured_share, iso20685_limit_mm, iso20685_ok, landmarks}), levels and omissions beside them.
[[nodiscard]] nlohmann::ordered_json MeasurementsToJson(const MeasurementTable& table);
/// One line per measurement: id,term,value_mm,sigma_mm,low95_mm,high95_mm,measured_share,iso20685_limit_mm,iso20685_ok.
[[nodiscard]] std::string MeasurementsToCsv(const MeasurementTable& table);
/// For a terminal.
[[nodiscard]] std::string MeasurementsToText(const MeasurementTable& table);

}  // namespace annulus
