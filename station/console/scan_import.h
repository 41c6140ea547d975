#pragma once

#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

/// POST /api/scans/import (docs/console_api.md §7): the body is a recording or a range table (CSV, gzip or not); a job
/// takes it in for a customer, judges it, and has it fitted.
[[nodiscard]] ApiResult ImportScan(ConsoleContext& context, const ApiRequest& request);

}  // namespace annulus
