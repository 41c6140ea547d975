#pragma once

#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

/// GET /api/scans/{scan}/document (docs/console_api.md §7): what a customer takes home, and for technicians and
/// administrators the recording.
[[nodiscard]] ApiResult ScanDocument(ConsoleContext& context, const ApiRequest& request);

}  // namespace annulus
