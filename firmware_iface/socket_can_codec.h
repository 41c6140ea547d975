#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "firmware_iface/can_bus.h"

namespace annulus {

/// The bytes that a SocketCAN raw socket gives and takes (struct can_frame, struct canfd_frame of linux/can.h), in this
/// machine's byte order. Also the payload of a LINKTYPE_CAN_SOCKETCAN capture but for the byte order of its first four.

/// A frame as the socket takes it: 16 bytes, or 72 for FD. Requires a frame that CAN can carry.
[[nodiscard]] std::vector<std::byte> EncodeSocketCan(const CanFrame& frame);

/// What one read of the socket means: a frame, or a report of the controller (an error frame). Nothing for bytes that
/// are neither.
[[nodiscard]] std::optional<std::variant<CanFrame, CanReport>> DecodeSocketCan(std::span<const std::byte> bytes);

/// What tells when a frame came to a socket.
struct SocketCanTimes {
  std::chrono::nanoseconds stamp{0};        ///< The kernel's, by the wall clock.
  std::chrono::nanoseconds wall_now{0};     ///< The wall clock when the frame was read.
  std::chrono::nanoseconds now{0};          ///< The host clock then.
  std::chrono::nanoseconds empty_since{0};  ///< The host clock when the socket was last known to hold nothing.
};

/// When the frame came, host clock. A wall clock that was set between stamp and read falsifies the frame's age: an age
/// below 0 or beyond what the frame can have is not believed, and the frame counts as just come.
[[nodiscard]] std::chrono::nanoseconds ArrivalOf(const SocketCanTimes& times);

}  // namespace annulus
