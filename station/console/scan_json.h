#pragma once

#include <nlohmann/json_fwd.hpp>

#include "station/console/route.h"
#include "station/store/store_types.h"

namespace annulus {

class Store;

/// `scan` of docs/console_api.md §7; without ids of people unless `who` is an operator.
[[nodiscard]] nlohmann::ordered_json ScanToJson(Store& store, const ScanRow& scan, StationRole who);
/// The summary of a scan as it is kept; {} if there is none.
[[nodiscard]] nlohmann::ordered_json SummaryOf(const ScanRow& scan);

}  // namespace annulus
