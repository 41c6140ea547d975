#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "modeling/measure/table.h"

namespace annulus {

/// A number for JSON: null where it is not finite.
[[nodiscard]] nlohmann::ordered_json JsonNumber(double value);

/// The table with the keys of DESIGN.md §3 (`measurements` of {id, term, definition, value_mm, sigma_mm, low95_mm,
/// high95_mm, measured_share, iso20685_limit_mm, iso20685_ok, landmarks}), levels and omissions beside them.
[[nodiscard]] nlohmann::ordered_json MeasurementsToJson(const MeasurementTable& table);
/// One line per measurement: id,term,value_mm,sigma_mm,low95_mm,high95_mm,measured_share,iso20685_limit_mm,iso20685_ok.
[[nodiscard]] std::string MeasurementsToCsv(const MeasurementTable& table);
/// For a terminal.
[[nodiscard]] std::string MeasurementsToText(const MeasurementTable& table);

}  // namespace annulus
