#pragma once

#include "modeling/exchange/pattern_file.h"

namespace annulus {

/// The table as FreeSewing's measurements: one flat JSON object of numbers, mm to 0.01 mm and degrees (shoulderSlope).
/// FreeSewing's core takes all numbers for millimetres or degrees by the name alone. Its names only: what it does not
/// know is left out, and names that cannot be filled are not invented.
[[nodiscard]] PatternFile MeasurementsToFreeSewing(const MeasurementTable& table);

}  // namespace annulus
