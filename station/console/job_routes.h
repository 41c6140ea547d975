#pragma once

#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

/// The caller's own jobs: list, one, cancel (docs/console_api.md §6).
void AddJobRoutes(RouteTable& table, ConsoleContext& context);

}  // namespace annulus
