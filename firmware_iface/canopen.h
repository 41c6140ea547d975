#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "firmware_iface/can_bus.h"

namespace annulus {

/// The parts of CiA 301 that the ring uses, as pure bytes: network management, SYNC, emergency, heartbeat. SDO is in
/// sdo.h. Decoders answer nothing for any frame that is not exactly theirs.

/// 1 … 127.
using NodeId = std::uint8_t;
inline constexpr NodeId kLastNodeId = 127;

/// Identifiers of the predefined connection set; where a node sends, its id is added.
enum class CobId : std::uint16_t {
  kNmt = 0x000,
  kSync = 0x080,
  kEmergency = 0x080,  ///< + node
  kTpdo1 = 0x180,
  kTpdo2 = 0x280,
  kTpdo3 = 0x380,
  kTpdo4 = 0x480,
  kSdoReply = 0x580,
  kSdoRequest = 0x600,
  kHeartbeat = 0x700,
};
[[nodiscard]] constexpr std::uint32_t CobIdOf(CobId function, NodeId node) {
  return static_cast<std::uint32_t>(function) + node;
}

/// A classic data frame with an 11-bit identifier.
[[nodiscard]] CanFrame ClassicFrame(std::uint32_t id, std::span<const std::byte> data);
/// Whether a frame is a classic or FD data frame with an 11-bit identifier: all that CANopen uses.
[[nodiscard]] bool IsCanopenFrame(const CanFrame& frame);

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kEnterPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};
struct NmtOrder {
  NmtCommand command = NmtCommand::kStart;
  NodeId node = 0;  ///< 0: all nodes.
  bool operator==(const NmtOrder&) const = default;
};
[[nodiscard]] CanFrame EncodeNmt(NmtOrder order);
[[nodiscard]] std::optional<NmtOrder> DecodeNmt(const CanFrame& frame);

/// The largest value of the SYNC counter that we set (1019h); after it comes 1.
inline constexpr std::uint8_t kSyncCounterOverflow = 240;
[[nodiscard]] CanFrame EncodeSync(std::uint8_t counter);
/// The counter, 1 … kSyncCounterOverflow. A SYNC without a counter is none of ours.
[[nodiscard]] std::optional<std::uint8_t> DecodeSync(const CanFrame& frame);

/// State as a heartbeat tells it.
enum class NmtState : std::uint8_t { kBootUp = 0x00, kStopped = 0x04, kOperational = 0x05, kPreOperational = 0x7F };
[[nodiscard]] const char* NmtStateText(NmtState state);
struct Heartbeat {
  NodeId node = 1;
  NmtState state = NmtState::kBootUp;
  bool operator==(const Heartbeat&) const = default;
};
[[nodiscard]] CanFrame EncodeHeartbeat(Heartbeat heartbeat);
[[nodiscard]] std::optional<Heartbeat> DecodeHeartbeat(const CanFrame& frame);

/// An emergency message. Our boards put their serial number into the manufacturer's bytes.
struct Emergency {
  NodeId node = 1;
  std::uint16_t code = 0;           ///< 0: the error is gone.
  std::uint8_t error_register = 0;  ///< Object 1001h.
  std::uint32_t serial = 0;         ///< Of the board.
  std::uint8_t detail = 0;          ///< Depends on the code.
  bool operator==(const Emergency&) const = default;
};
[[nodiscard]] CanFrame EncodeEmergency(const Emergency& emergency);
[[nodiscard]] std::optional<Emergency> DecodeEmergency(const CanFrame& frame);

// Emergency codes that our boards send.
inline constexpr std::uint16_t kEmergencyNone = 0x0000;
inline constexpr std::uint16_t kEmergencyOverrun = 0x8110;
inline constexpr std::uint16_t kEmergencyErrorPassive = 0x8120;
inline constexpr std::uint16_t kEmergencyBusOffRecovered = 0x8140;
inline constexpr std::uint16_t kEmergencySameNodeId = 0x8150;
inline constexpr std::uint16_t kEmergencySyncLength = 0x8240;
inline constexpr std::uint16_t kEmergencyEmitter = 0xFF10;

/// What an emergency code means, after CiA 301's table of code classes: "8130h: no heartbeat from a node that it
/// watches".
[[nodiscard]] std::string EmergencyText(std::uint16_t code);
/// Whether a board with this emergency can go on measuring: it only reports load or weak wiring.
[[nodiscard]] bool IsWarning(std::uint16_t emergency_code);

}  // namespace annulus
