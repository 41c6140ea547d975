#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware_iface/usb_port.h"

namespace annulus::sim {

inline constexpr std::uint8_t kDeviceDescriptor = 1;
inline constexpr std::uint8_t kConfigurationDescriptor = 2;
inline constexpr std::uint8_t kStringDescriptor = 3;
/// Bytes of a bulk packet at high speed.
inline constexpr std::uint16_t kBulkPacketBytes = 512;

/// A ring board's answer to GET_DESCRIPTOR (docs/wire_protocol.md, 1.5): `value` is wValue, type in the high byte,
/// index in the low one. Nothing for a descriptor that it has not: the board stalls.
std::optional<std::vector<std::byte>> BoardDescriptor(const UsbIdentity& identity, std::uint16_t value);

}  // namespace annulus::sim
