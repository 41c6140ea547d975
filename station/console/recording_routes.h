#pragma once

#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

/// The technician's list of recordings, what is in one, and what can be saved of a damaged one. No customers.
void AddRecordingRoutes(RouteTable& table, ConsoleContext& context);

}  // namespace annulus
