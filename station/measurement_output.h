#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "modeling/table/table.h"

namespace annulus {

/// A number for JSON: null where it is not finite.
[[nodiscard]] nlohmann::ordered_json JsonNumber(double value);

/// Half width of the two-sided 95 % interval of a normal error; NaN where sigma is.
[[nodiscard]] double HalfWidth95(const Uncertain& value);

/// "± 0.35 (95 %)": that half width in the value's unit, for a terminal; "± not known" where sigma is NaN.
[[nodiscard]] std::string HalfWidth95Text(const Uncertain& value, int decimals);

/// Whether the 95 % interval is within the class limit; nothing where there is no limit or no sigma.
[[nodiscard]] std::optional<bool> IntervalWithinLimit(const Measurement& measurement);

/// Why something is left out, and what: "WAIST, HIP".
struct NamesOfReason {
  std::string reason;
  std::string names;
};
/// Sentences "NAME: REASON." with each reason once, in the order in which the reasons come.
[[nodiscard]] std::vector<NamesOfReason> GatherByReason(const std::vector<std::string>& sentences);

/// The parts of the budget of which the model knows nothing, so that no sigma of the table holds them: "calibration",
/// "sway".
[[nodiscard]] std::vector<std::string> ErrorsLeftOut(const MeasurementTable& table);

/// The table with the keys of DESIGN.md §3 (`measurements` of {id, term, definition, value_mm, sigma_mm, low95_mm,
/// high95_mm, measured_share, iso20685_limit_mm, iso20685_ok, landmarks}) and, beside them, method, the parts of sigma,
/// a note on landmarks that were not detected, the landmarks themselves, levels and omissions (docs/formats.md).
[[nodiscard]] nlohmann::ordered_json MeasurementsToJson(const MeasurementTable& table);
/// One line per measurement, numbers in its own unit:
/// id,term,unit,value,sigma,low95,high95,measured_share,iso20685_limit_mm,iso20685_ok,method,landmarks,note.
[[nodiscard]] std::string MeasurementsToCsv(const MeasurementTable& table);
/// For a terminal: lengths in mm, areas in cm², volumes in litres, what is not detected or not seen noted.
[[nodiscard]] std::string MeasurementsToText(const MeasurementTable& table);

}  // namespace annulus
