#pragma once

#include <string>
#include <vector>

#include "firmware_iface/can_bus.h"

namespace annulus {

/// What the system's rtnetlink says of CAN interfaces (linux/can/netlink.h, linux/if_link.h). Each call waits 1 s at
/// most.

/// One interface by name; kGone if there is none of this name, or if it is no CAN interface.
CanResult<CanLink> ReadCanLink(const std::string& name);
/// All CAN interfaces.
CanResult<std::vector<CanLink>> ReadCanLinks();
/// Restarts a controller that is bus-off. Needs CAP_NET_ADMIN.
CanResult<void> RestartCanLink(const std::string& name);

}  // namespace annulus
