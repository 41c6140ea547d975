#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"

namespace annulus::sim {

/// A simulated bus and a real one that shall be one: every frame of each is sent on the other. Both are borrowed.
struct CanBridge {
  CanBus* simulated = nullptr;
  CanBus* real = nullptr;
};

struct CanBridgeCounts {
  std::uint64_t to_real = 0;
  std::uint64_t to_simulated = 0;
  std::uint64_t dropped = 0;   ///< For want of room, or while the real bus was down.
  std::uint64_t reopened = 0;  ///< Times that the real bus had to be bound again.
};

/// Serves simulated boards on real buses (a socket, a child process) in real time, until asked to stop or until
/// `on_turn`, called every half millisecond or oftener in this thread, says false; there the boards may be changed. A
/// real bus that goes down is waited for. The clock must be the simulated buses' and the real ones', the system's.
CanBridgeCounts ServeCanBoards(const std::vector<CanBridge>& bridges, Clock& clock, const std::stop_token& stop,
                               const std::function<bool(std::chrono::nanoseconds now)>& on_turn = {});

}  // namespace annulus::sim
