#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "fitting/sway.h"

namespace annulus {

/// The scan whose sway counts when several were fitted together: the one that leaves most. Null if there is none.
[[nodiscard]] const SwayEstimate* WorstSway(const std::vector<SwayEstimate>& scans);

/// The `sway` of a fit's report (docs/formats.md), of the scan that counts; null if there is none.
[[nodiscard]] nlohmann::ordered_json SwayReport(const std::vector<SwayEstimate>& scans);

}  // namespace annulus
