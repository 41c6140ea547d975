#pragma once

#include <functional>
#include <string>

#include "station/console/console_context.h"

namespace annulus {

class Accounts;
class ConsoleAudit;
class Sessions;

/// What the routes of sessions and administration need beside the ConsoleContext. All borrowed, all thread-safe, all
/// living as long as the console.
struct ConsoleFrame {
  Accounts& accounts;
  Sessions& sessions;
  ConsoleAudit& audit;
  /// Why the certificate cannot be relied on now; "" if it can.
  std::function<std::string()> certificate_problem;
};

/// All routes of the console: the server serves these, and the test of routes and roles goes through these.
void AddAllRoutes(RouteTable& table, ConsoleContext& context, ConsoleFrame& frame);

}  // namespace annulus
