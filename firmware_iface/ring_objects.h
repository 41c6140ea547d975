#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "firmware_iface/little_endian.h"
#include "firmware_iface/sdo.h"

namespace annulus {

/// The objects of a ring board on CAN (docs/wire_protocol.md §2.2).

inline constexpr std::uint16_t kCanRingProtocolVersion = 1;

// Of CiA 301.
inline constexpr SdoAddress kObjectDeviceType{0x1000, 0};
inline constexpr SdoAddress kObjectErrorRegister{0x1001, 0};
inline constexpr SdoAddress kObjectSyncId{0x1005, 0};      ///< u32: identifier, bit 30: this node produces SYNC.
inline constexpr SdoAddress kObjectSyncPeriod{0x1006, 0};  ///< u32, us.
inline constexpr SdoAddress kObjectDeviceName{0x1008, 0};
inline constexpr SdoAddress kObjectFirmwareVersion{0x100A, 0};      ///< Text "1.2.0".
inline constexpr SdoAddress kObjectEmergencyId{0x1014, 0};          ///< u32.
inline constexpr SdoAddress kObjectHeartbeat{0x1017, 0};            ///< u16, ms between beats; 0: none.
inline constexpr SdoAddress kObjectVendor{0x1018, 1};               ///< u32.
inline constexpr SdoAddress kObjectProduct{0x1018, 2};              ///< u32.
inline constexpr SdoAddress kObjectRevision{0x1018, 3};             ///< u32.
inline constexpr SdoAddress kObjectSerial{0x1018, 4};               ///< u32.
inline constexpr SdoAddress kObjectSyncCounterOverflow{0x1019, 0};  ///< u8.

// Of the ring.
inline constexpr SdoAddress kObjectProtocolVersion{0x2000, 0};  ///< u16.
inline constexpr SdoAddress kObjectFirstSensor{0x2001, 0};      ///< u16.
inline constexpr SdoAddress kObjectSensorCount{0x2002, 0};      ///< u8.
inline constexpr SdoAddress kObjectMinLevelRate{0x2003, 1};     ///< u32, mHz.
inline constexpr SdoAddress kObjectMaxLevelRate{0x2003, 2};     ///< u32, mHz.
/// u32, us of the board's clock, latched when the request arrives. Sub-indices 1 … kClockSubIndices all read it: each
/// question uses another, so that a late answer is never taken for that of the next question.
inline constexpr std::uint16_t kClockIndex = 0x2004;
inline constexpr std::uint8_t kClockSubIndices = 16;
inline constexpr SdoAddress kObjectNmtState{0x2005, 0};  ///< u8, as a heartbeat tells it, at once.
/// u8: 1: this board drives the SYNC wire; 0: it listens to it. Only a SYNC producer heeds it.
inline constexpr SdoAddress kObjectDrivesSyncWire{0x2006, 0};
inline constexpr SdoAddress kObjectFdLevels{0x2007, 0};  ///< u8: 1: levels in FD frames.

inline constexpr std::uint32_t kSyncProducerBit = 1U << 30;
inline constexpr std::uint32_t kRingVendor = 0;  ///< We have none of CAN in Automation.
inline constexpr std::uint32_t kRingProduct = 0xA180;

/// An object of 1, 2 or 4 bytes as bytes.
template <class Unsigned>
[[nodiscard]] std::vector<std::byte> ObjectBytes(Unsigned value) {
  std::vector<std::byte> bytes(sizeof(Unsigned));
  PutLittleEndian(std::span<std::byte>(bytes), value);
  return bytes;
}

}  // namespace annulus
