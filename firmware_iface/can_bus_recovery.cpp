#include "firmware_iface/can_bus_recovery.h"

#include <algorithm>
#include <string>

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kRestartPause = std::chrono::seconds(1);
constexpr int kMostRestarts = 5;
constexpr nanoseconds kPollPause = std::chrono::milliseconds(50);

}  // namespace

Status CanBusRecovery::BringBack(CanRingBus& bus, nanoseconds deadline, Clock& clock) {
  bus.CollectAll();
  RETURN_IF_ERROR(Bind(bus, deadline, clock));
  bus.Forgive();
  return LeaveBusOff(bus, deadline, clock);
}

Status CanBusRecovery::Bind(CanRingBus& bus, nanoseconds deadline, Clock& clock) {
  const auto is_down = [&] {
    const auto link = bus.bus().ReadLink();
    return !link || link->state == CanState::kDown || bus.health().state == CanState::kDown;
  };
  while (is_down()) {
    const auto bound = bus.Rebind();
    if (bound && bus.health().state != CanState::kDown) return {};
    if (clock.Now() >= deadline) {
      return Fail("open " + bus.name() + " again", bound ? "the CAN interface is down" : CanFailureText(bound.error()),
                  "bring the interface up (ip link set " + bus.name() + " up) or plug in its adapter");
    }
    clock.SleepUntil(std::min(deadline, clock.Now() + kPollPause));
  }
  return {};
}

Status CanBusRecovery::LeaveBusOff(CanRingBus& bus, nanoseconds deadline, Clock& clock) {
  const std::string attempted = "bring " + bus.name() + " back from bus-off";
  std::string refused;
  while (true) {
    const auto link = bus.bus().ReadLink();
    if (link && link->state != CanState::kBusOff) return {};
    const bool by_itself = link && link->restart_ms.value_or(0) > 0;
    const nanoseconds due = last_restart_ ? *last_restart_ + kRestartPause : clock.Now();
    if (!by_itself && clock.Now() >= due) {
      if (restarts_ == kMostRestarts) {
        return Fail(attempted, "restarted 5 times in vain" + refused,
                    "check the bus' wiring, termination and bit rate, then start the program again");
      }
      ++restarts_;
      last_restart_ = clock.Now();
      if (const auto done = bus.bus().Restart(); !done) refused = " (" + CanFailureText(done.error()) + ")";
    }
    if (clock.Now() >= deadline) {
      return Fail(attempted, "it is still bus-off" + refused,
                  "check the bus' wiring, termination and bit rate; set restart-ms to 1000");
    }
    bus.Collect(std::min(deadline, clock.Now() + kPollPause));
    bus.Forgive();
  }
}

}  // namespace annulus
