#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace annulus {

inline constexpr std::size_t kSensorsPerBoard = 15;
inline constexpr std::uint8_t kRingProtocolVersion = 1;
/// Bytes of a level frame (docs/wire_protocol.md).
inline constexpr std::size_t kLevelFrameBytes = 108;
/// range_um of a sensor that saw nothing.
inline constexpr std::uint32_t kNoReturn = 0xFFFFFFFFU;
/// Bit of LevelFrame::status: the emitters' power is outside its limits.
inline constexpr std::uint8_t kFrameEmitterFault = 1U << 0;

/// What one board measured at one SYNC.
struct LevelFrame {
  std::uint32_t board_serial = 0;
  std::uint32_t sequence = 0;                              ///< SYNC edges since the board was armed.
  std::chrono::nanoseconds device_time{0};                 ///< The board's clock when the sensors fired; >= 0.
  std::uint8_t status = 0;                                 ///< kFrame… bits.
  std::int16_t temperature_centi_c = 0;                    ///< 0.01 degrees Celsius.
  std::array<std::uint32_t, kSensorsPerBoard> range_um{};  ///< um, or kNoReturn.
  std::array<std::uint8_t, kSensorsPerBoard> quality{};    ///< 0 … 255.

  bool operator==(const LevelFrame&) const = default;
};

/// The frame as bytes, checksum included.
[[nodiscard]] std::array<std::byte, kLevelFrameBytes> EncodeLevelFrame(const LevelFrame& frame);

/// Finds level frames in a stream of bytes. Takes chunks cut anywhere and gives the same frames whatever the cuts;
/// skips what is no frame, byte by byte, so that damage costs only the frames it touches. Holds less than one frame.
class UsbFrameAssembler {
 public:
  /// Adds bytes; returns the frames that became whole, in stream order.
  std::vector<LevelFrame> Push(std::span<const std::byte> chunk);

  /// Bytes so far that turned out to belong to no good frame.
  [[nodiscard]] std::uint64_t rejected_bytes() const { return rejected_bytes_; }
  /// Places that looked like a frame (magic, version and length right) but had a wrong checksum or content.
  [[nodiscard]] std::uint64_t rejected_frames() const { return rejected_frames_; }
  /// Bytes that may still become a frame.
  [[nodiscard]] std::size_t pending_bytes() const { return buffer_.size(); }

 private:
  std::vector<std::byte> buffer_;
  std::uint64_t rejected_bytes_ = 0;
  std::uint64_t rejected_frames_ = 0;
};

/// Vendor requests of a board (bRequest).
enum class BoardRequest : std::uint8_t {
  kIdentify = 0x01,   ///< IN: BoardIdentity.
  kArm = 0x10,        ///< OUT: u32 level rate in mHz. Sequence back to 0; waits for SYNC.
  kStartSync = 0x11,  ///< OUT, no data: this board drives the SYNC line.
  kStop = 0x12,       ///< OUT, no data: no more SYNC from this board, disarm, drop what was not sent.
  kReadClock = 0x13,  ///< IN: u64 ns, latched when the request arrives.
};

/// Endpoint of the level frames.
inline constexpr std::uint8_t kLevelEndpoint = 0x81;
inline constexpr std::size_t kBoardIdentityBytes = 24;

/// A board's answer to kIdentify.
struct BoardIdentity {
  std::uint8_t protocol_version = kRingProtocolVersion;
  std::array<std::uint8_t, 3> firmware_version{};  ///< Major, minor, patch.
  std::uint8_t sensor_count = kSensorsPerBoard;
  std::uint32_t serial = 0;
  std::uint16_t first_sensor = 0;
  std::uint32_t min_level_rate_mhz = 0;  ///< mHz.
  std::uint32_t max_level_rate_mhz = 0;  ///< mHz.

  bool operator==(const BoardIdentity&) const = default;
};

[[nodiscard]] std::array<std::byte, kBoardIdentityBytes> EncodeBoardIdentity(const BoardIdentity& identity);
/// Fails on a wrong length or magic; does not judge the version. (Control transfers have their own checksum.)
Result<BoardIdentity> DecodeBoardIdentity(std::span<const std::byte> bytes);

/// Payloads of kArm and kReadClock.
[[nodiscard]] std::array<std::byte, 4> EncodeLevelRate(std::uint32_t level_rate_mhz);
Result<std::uint32_t> DecodeLevelRate(std::span<const std::byte> bytes);
[[nodiscard]] std::array<std::byte, 8> EncodeDeviceTime(std::chrono::nanoseconds time);
Result<std::chrono::nanoseconds> DecodeDeviceTime(std::span<const std::byte> bytes);

}  // namespace annulus
