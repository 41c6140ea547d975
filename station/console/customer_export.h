#pragma once

#include <chrono>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "station/store/store_types.h"

namespace annulus {

class Store;

/// A zip of all that the store knows of a customer, opened: customer.json, consents.json, and for every scan a folder
/// with scan.json, the recording (.mcap) and every artefact. A recording that is missing is named in scan.json.
/// `known`: the customer as the console shows it.
Result<std::string> ExportOfCustomer(Store& store, const Customer& customer, const nlohmann::ordered_json& known,
                                     std::chrono::nanoseconds wall);

}  // namespace annulus
