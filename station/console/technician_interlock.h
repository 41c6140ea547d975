#pragma once

#include <nlohmann/json_fwd.hpp>

#include "acquisition/scanner.h"

namespace annulus {

/// GET /api/technician/interlock: {lines: [{name, direction, level, meaning, stops}], changed_ns, held_by, chain:
/// [{fault_present, text, advice, since_ns}], chain_closed}. Levels are as the booth last said them, null before that;
/// times are the booth's clock.
[[nodiscard]] nlohmann::ordered_json InterlockJson(const ScannerStatus& status);

}  // namespace annulus
