#pragma once

#include <chrono>
#include <optional>

#include "firmware_iface/can_ring_bus.h"

namespace annulus {

/// Brings a bus back into operation: binds it anew when it was down or gone, restarts its controller from bus-off. At
/// most one restart a second and five in the life of a recovery, which ends with a good start.
class CanBusRecovery {
 public:
  /// Fails, saying what to do, if the bus is not back by `deadline` or has been restarted too often. Starts nothing
  /// else.
  Status BringBack(CanRingBus& bus, std::chrono::nanoseconds deadline, Clock& clock);

 private:
  Status Bind(CanRingBus& bus, std::chrono::nanoseconds deadline, Clock& clock);
  Status LeaveBusOff(CanRingBus& bus, std::chrono::nanoseconds deadline, Clock& clock);

  int restarts_ = 0;
  std::optional<std::chrono::nanoseconds> last_restart_;
};

}  // namespace annulus
