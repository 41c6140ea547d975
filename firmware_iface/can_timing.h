#pragma once

#include <chrono>
#include <cstdint>

#include "firmware_iface/can_bus.h"

namespace annulus {

struct CanBitRates {
  std::uint32_t nominal = 1'000'000;  ///< bit/s.
  std::uint32_t data = 4'000'000;     ///< bit/s, of FD frames that switch.
};

/// The longest that a frame can be on the bus, from start of frame to the end of the interframe space, with as many
/// stuff bits as its content could make. Classic: g + 8n + 13 + ⌊(g + 8n − 1)/4⌋ bits with g = 34 (11-bit identifier)
/// or 54 (Davis et al. 2007, eq. 1). FD: counted the same way over both phases of ISO 11898-1.
[[nodiscard]] std::chrono::nanoseconds LongestFrameTime(const CanFrame& frame, CanBitRates rates);

}  // namespace annulus
