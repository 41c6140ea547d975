#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "base/result.h"
#include "station/console/route.h"
#include "station/store/store_types.h"

namespace annulus {

class Store;

/// `scan` of docs/console_api.md §7; without ids of people unless `who` is an operator.
[[nodiscard]] nlohmann::ordered_json ScanToJson(Store& store, const ScanRow& scan, StationRole who);
/// `artefact` of §7: {id, kind, name, derived, made_ms, bytes}.
[[nodiscard]] nlohmann::ordered_json ArtefactJson(const Artefact& artefact);
/// The newest artefact of a kind that a scan has. Fails, saying what to do, if there is none.
[[nodiscard]] Result<Artefact> NewestArtefact(Store& store, const std::string& scan_id, std::string_view kind);
/// The summary of a scan as it is kept; {} if there is none.
[[nodiscard]] nlohmann::ordered_json SummaryOf(const ScanRow& scan);

}  // namespace annulus
