#include "firmware_iface/canopen.h"

#include <algorithm>
#include <cstdio>

#include "base/ensure.h"
#include "firmware_iface/little_endian.h"

namespace annulus {
namespace {

constexpr std::size_t kEmergencyBytes = 8;

/// The node of a frame of this function, if it has one and its data are of this size.
std::optional<NodeId> NodeOf(const CanFrame& frame, CobId function, std::size_t size) {
  const auto base = static_cast<std::uint32_t>(function);
  if (!IsCanopenFrame(frame) || frame.fd || frame.size != size) return std::nullopt;
  if (frame.id <= base || frame.id > base + kLastNodeId) return std::nullopt;
  return static_cast<NodeId>(frame.id - base);
}

std::uint8_t ByteAt(const CanFrame& frame, std::size_t at) { return std::to_integer<std::uint8_t>(frame.data[at]); }

struct CodeText {
  std::uint16_t code;
  const char* text;
};

/// Exact codes first, then the classes of CiA 301 by their high byte, then by their first digit.
constexpr CodeText kExact[] = {
    {kEmergencyNone, "no error any more"},
    {kEmergencyOverrun, "it lost CAN messages: overrun"},
    {kEmergencyErrorPassive, "its CAN controller is error-passive"},
    {0x8130, "it misses a heartbeat that it watches"},
    {kEmergencyBusOffRecovered, "it came back from bus-off"},
    {kEmergencySameNodeId, "another node on the bus uses its node id"},
    {0x8210, "a PDO of wrong length was not processed"},
    {0x8220, "a PDO was too long"},
    {kEmergencySyncLength, "a SYNC of unexpected length came"},
    {0x8250, "a PDO did not come in time"},
    {kEmergencyEmitter, "an emitter's power is outside its limits"},
};
constexpr CodeText kByHighByte[] = {
    {0x1000, "general error"},
    {0x2100, "input current"},
    {0x2200, "current inside the board"},
    {0x2300, "output current"},
    {0x3100, "supply voltage"},
    {0x3200, "voltage inside the board"},
    {0x3300, "output voltage"},
    {0x4100, "ambient temperature"},
    {0x4200, "temperature of the board"},
    {0x5000, "hardware of the board"},
    {0x6100, "internal software"},
    {0x6200, "user software"},
    {0x6300, "data set"},
    {0x7000, "additional modules"},
    {0x8000, "monitoring"},
    {0x8100, "communication"},
    {0x8200, "protocol"},
    {0x9000, "external error"},
    {0xF000, "additional functions"},
    {0xFF00, "device specific"},
};

const char* TextOf(std::uint16_t code) {
  for (const CodeText& known : kExact) {
    if (known.code == code) return known.text;
  }
  for (const std::uint16_t mask : {std::uint16_t{0xFF00}, std::uint16_t{0xF000}}) {
    for (const CodeText& known : kByHighByte) {
      if (known.code == (code & mask)) return known.text;
    }
  }
  return "unknown error";
}

}  // namespace

CanFrame ClassicFrame(std::uint32_t id, std::span<const std::byte> data) {
  ENSURE(id <= 0x7FF && data.size() <= 8, "a classic frame has an 11-bit id and at most 8 bytes");
  CanFrame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

bool IsCanopenFrame(const CanFrame& frame) {
  return !frame.extended && !frame.remote && frame.id <= 0x7FF &&
         (frame.fd ? IsCanFdSize(frame.size) : frame.size <= 8);
}

CanFrame EncodeNmt(NmtOrder order) {
  return ClassicFrame(0, std::array{static_cast<std::byte>(order.command), std::byte{order.node}});
}

std::optional<NmtOrder> DecodeNmt(const CanFrame& frame) {
  if (!IsCanopenFrame(frame) || frame.fd || frame.id != 0 || frame.size != 2) return std::nullopt;
  const NmtOrder order{static_cast<NmtCommand>(ByteAt(frame, 0)), ByteAt(frame, 1)};
  if (order.node > kLastNodeId) return std::nullopt;
  switch (order.command) {
    case NmtCommand::kStart:
    case NmtCommand::kStop:
    case NmtCommand::kEnterPreOperational:
    case NmtCommand::kResetNode:
    case NmtCommand::kResetCommunication:
      return order;
  }
  return std::nullopt;
}

CanFrame EncodeSync(std::uint8_t counter) {
  return ClassicFrame(static_cast<std::uint32_t>(CobId::kSync), std::array{std::byte{counter}});
}

std::optional<std::uint8_t> DecodeSync(const CanFrame& frame) {
  if (!IsCanopenFrame(frame) || frame.fd || frame.id != static_cast<std::uint32_t>(CobId::kSync) || frame.size != 1) {
    return std::nullopt;
  }
  const std::uint8_t counter = ByteAt(frame, 0);
  if (counter == 0 || counter > kSyncCounterOverflow) return std::nullopt;
  return counter;
}

const char* NmtStateText(NmtState state) {
  switch (state) {
    case NmtState::kBootUp:
      return "booting";
    case NmtState::kStopped:
      return "stopped";
    case NmtState::kOperational:
      return "operational";
    case NmtState::kPreOperational:
      return "pre-operational";
  }
  return "in an unknown state";
}

CanFrame EncodeHeartbeat(Heartbeat heartbeat) {
  return ClassicFrame(CobIdOf(CobId::kHeartbeat, heartbeat.node), std::array{static_cast<std::byte>(heartbeat.state)});
}

std::optional<Heartbeat> DecodeHeartbeat(const CanFrame& frame) {
  const auto node = NodeOf(frame, CobId::kHeartbeat, 1);
  if (!node) return std::nullopt;
  const auto state = static_cast<NmtState>(ByteAt(frame, 0));
  switch (state) {
    case NmtState::kBootUp:
    case NmtState::kStopped:
    case NmtState::kOperational:
    case NmtState::kPreOperational:
      return Heartbeat{*node, state};
  }
  return std::nullopt;
}

CanFrame EncodeEmergency(const Emergency& emergency) {
  std::array<std::byte, kEmergencyBytes> bytes{};
  const std::span<std::byte> out(bytes);
  PutLittleEndian(out, emergency.code);
  bytes[2] = std::byte{emergency.error_register};
  PutLittleEndian(out.subspan(3), emergency.serial);
  bytes[7] = std::byte{emergency.detail};
  return ClassicFrame(CobIdOf(CobId::kEmergency, emergency.node), bytes);
}

std::optional<Emergency> DecodeEmergency(const CanFrame& frame) {
  const auto node = NodeOf(frame, CobId::kEmergency, kEmergencyBytes);
  if (!node) return std::nullopt;
  const std::span<const std::byte> bytes(frame.data);
  Emergency emergency;
  emergency.node = *node;
  emergency.code = GetLittleEndian<std::uint16_t>(bytes);
  emergency.error_register = ByteAt(frame, 2);
  emergency.serial = GetLittleEndian<std::uint32_t>(bytes.subspan(3));
  emergency.detail = ByteAt(frame, 7);
  return emergency;
}

std::string EmergencyText(std::uint16_t code) {
  char hex[8];
  std::snprintf(hex, sizeof(hex), "%04Xh", static_cast<unsigned>(code));
  return std::string(hex) + ": " + TextOf(code);
}

bool IsWarning(std::uint16_t emergency_code) {
  return emergency_code == kEmergencyNone || emergency_code == kEmergencyOverrun ||
         emergency_code == kEmergencyErrorPassive;
}

}  // namespace annulus
