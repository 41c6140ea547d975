#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

/// The set-up stage of any control request, as chapter 9 of the USB specification has it.
struct UsbSetup {
  std::uint8_t type = 0;  ///< bmRequestType.
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

/// A ring board's answer to any control request: standard ones from its descriptors, vendor requests by the firmware
/// behind `board`. `data` came with a request to the device.
UsbResult<std::vector<std::byte>> AnswerSetup(UsbPort& board, const UsbSetup& setup, std::span<const std::byte> data,
                                              std::chrono::nanoseconds timeout);

}  // namespace annulus::sim
