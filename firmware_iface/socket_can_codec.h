#pragma once

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

}  // namespace annulus
