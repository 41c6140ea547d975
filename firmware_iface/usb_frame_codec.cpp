#include "firmware_iface/usb_frame_codec.h"

#include <algorithm>
#include <optional>

#include "firmware_iface/crc32c.h"
#include "firmware_iface/little_endian.h"

namespace annulus {
namespace {

using Bytes = std::span<const std::byte>;

/// "ANRL" on the wire.
constexpr std::array<std::byte, 4> kFrameMagic{std::byte{'A'}, std::byte{'N'}, std::byte{'R'}, std::byte{'L'}};
/// "ANRI" on the wire.
constexpr std::array<std::byte, 4> kIdentityMagic{std::byte{'A'}, std::byte{'N'}, std::byte{'R'}, std::byte{'I'}};

// Offsets of docs/wire_protocol.md, "Level frame".
constexpr std::size_t kVersionAt = 4;
constexpr std::size_t kStatusAt = 5;
constexpr std::size_t kLengthAt = 6;
constexpr std::size_t kSerialAt = 8;
constexpr std::size_t kSequenceAt = 12;
constexpr std::size_t kTimeAt = 16;
constexpr std::size_t kTemperatureAt = 24;
constexpr std::size_t kSensorCountAt = 26;
constexpr std::size_t kRangesAt = 28;
constexpr std::size_t kQualitiesAt = kRangesAt + 4 * kSensorsPerBoard;
constexpr std::size_t kChecksumAt = kLevelFrameBytes - 4;
constexpr std::size_t kHeaderBytes = kSerialAt;
static_assert(kQualitiesAt + kSensorsPerBoard + 1 == kChecksumAt);

constexpr std::uint64_t kLargestTime = 0x7FFFFFFFFFFFFFFFULL;

bool ChecksumFits(Bytes bytes) {
  const std::size_t body = bytes.size() - 4;
  return Crc32c(bytes.first(body)) == GetLittleEndian<std::uint32_t>(bytes.subspan(body));
}

void PutChecksum(std::span<std::byte> bytes) {
  const std::size_t body = bytes.size() - 4;
  PutLittleEndian(bytes.subspan(body), Crc32c(bytes.first(body)));
}

/// Index of the first byte from which on `bytes` begins like the magic, or the size.
std::size_t FindMagic(Bytes bytes) {
  auto at = bytes.begin();
  while (true) {
    at = std::find(at, bytes.end(), kFrameMagic[0]);
    const auto known = std::min<std::ptrdiff_t>(bytes.end() - at, kFrameMagic.size());
    if (std::equal(at, at + known, kFrameMagic.begin())) return static_cast<std::size_t>(at - bytes.begin());
    ++at;
  }
}

bool HeaderFits(Bytes header) {
  return std::to_integer<std::uint8_t>(header[kVersionAt]) == kRingProtocolVersion &&
         GetLittleEndian<std::uint16_t>(header.subspan(kLengthAt)) == kLevelFrameBytes;
}

/// A frame of the right size and header, if checksum and content are right.
std::optional<LevelFrame> DecodeLevelFrame(Bytes bytes) {
  const std::uint64_t time = GetLittleEndian<std::uint64_t>(bytes.subspan(kTimeAt));
  const auto sensor_count = std::to_integer<std::size_t>(bytes[kSensorCountAt]);
  if (!ChecksumFits(bytes) || time > kLargestTime || sensor_count != kSensorsPerBoard) return std::nullopt;

  LevelFrame frame;
  frame.board_serial = GetLittleEndian<std::uint32_t>(bytes.subspan(kSerialAt));
  frame.sequence = GetLittleEndian<std::uint32_t>(bytes.subspan(kSequenceAt));
  frame.device_time = std::chrono::nanoseconds(static_cast<std::int64_t>(time));
  frame.status = std::to_integer<std::uint8_t>(bytes[kStatusAt]);
  frame.temperature_centi_c = static_cast<std::int16_t>(GetLittleEndian<std::uint16_t>(bytes.subspan(kTemperatureAt)));
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    frame.range_um[i] = GetLittleEndian<std::uint32_t>(bytes.subspan(kRangesAt + 4 * i));
    frame.quality[i] = std::to_integer<std::uint8_t>(bytes[kQualitiesAt + i]);
  }
  return frame;
}

template <class Unsigned>
Result<Unsigned> DecodeNumber(Bytes bytes, const char* what) {
  if (bytes.size() != sizeof(Unsigned)) {
    return Fail(std::string("decode ") + what,
                std::to_string(bytes.size()) + " bytes instead of " + std::to_string(sizeof(Unsigned)),
                "check the board's firmware version");
  }
  return GetLittleEndian<Unsigned>(bytes);
}

}  // namespace

std::array<std::byte, kLevelFrameBytes> EncodeLevelFrame(const LevelFrame& frame) {
  std::array<std::byte, kLevelFrameBytes> bytes{};
  const std::span<std::byte> out(bytes);
  std::copy(kFrameMagic.begin(), kFrameMagic.end(), bytes.begin());
  bytes[kVersionAt] = std::byte{kRingProtocolVersion};
  bytes[kStatusAt] = std::byte{frame.status};
  PutLittleEndian(out.subspan(kLengthAt), static_cast<std::uint16_t>(kLevelFrameBytes));
  PutLittleEndian(out.subspan(kSerialAt), frame.board_serial);
  PutLittleEndian(out.subspan(kSequenceAt), frame.sequence);
  PutLittleEndian(out.subspan(kTimeAt), static_cast<std::uint64_t>(frame.device_time.count()));
  PutLittleEndian(out.subspan(kTemperatureAt), static_cast<std::uint16_t>(frame.temperature_centi_c));
  bytes[kSensorCountAt] = static_cast<std::byte>(kSensorsPerBoard);
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    PutLittleEndian(out.subspan(kRangesAt + 4 * i), frame.range_um[i]);
    bytes[kQualitiesAt + i] = std::byte{frame.quality[i]};
  }
  PutChecksum(out);
  return bytes;
}

std::vector<LevelFrame> UsbFrameAssembler::Push(std::span<const std::byte> chunk) {
  buffer_.insert(buffer_.end(), chunk.begin(), chunk.end());
  std::vector<LevelFrame> frames;
  std::size_t at = 0;
  // Each decision looks only at bytes from `at` on and waits when too few are there: hence independent of the cuts.
  while (true) {
    const std::size_t skipped = FindMagic(Bytes(buffer_).subspan(at));
    at += skipped;
    rejected_bytes_ += skipped;
    const Bytes rest = Bytes(buffer_).subspan(at);
    if (rest.size() < kHeaderBytes) break;
    if (HeaderFits(rest)) {
      if (rest.size() < kLevelFrameBytes) break;
      if (const auto frame = DecodeLevelFrame(rest.first(kLevelFrameBytes))) {
        frames.push_back(*frame);
        at += kLevelFrameBytes;
        continue;
      }
      ++rejected_frames_;
    }
    // One byte only: the next good frame may begin inside what looked like this one.
    ++at;
    ++rejected_bytes_;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  return frames;
}

std::array<std::byte, kBoardIdentityBytes> EncodeBoardIdentity(const BoardIdentity& identity) {
  std::array<std::byte, kBoardIdentityBytes> bytes{};
  const std::span<std::byte> out(bytes);
  std::copy(kIdentityMagic.begin(), kIdentityMagic.end(), bytes.begin());
  bytes[4] = static_cast<std::byte>(identity.protocol_version);
  for (std::size_t i = 0; i < 3; ++i) bytes[5 + i] = std::byte{identity.firmware_version[i]};
  PutLittleEndian(out.subspan(8), identity.serial);
  PutLittleEndian(out.subspan(12), identity.first_sensor);
  bytes[14] = std::byte{identity.sensor_count};
  PutLittleEndian(out.subspan(16), identity.max_level_rate_mhz);
  PutLittleEndian(out.subspan(20), identity.min_level_rate_mhz);
  return bytes;
}

Result<BoardIdentity> DecodeBoardIdentity(std::span<const std::byte> bytes) {
  if (bytes.size() != kBoardIdentityBytes || !std::equal(kIdentityMagic.begin(), kIdentityMagic.end(), bytes.begin())) {
    return Fail("decode the board's identity",
                std::to_string(bytes.size()) + " bytes that are not " + std::to_string(kBoardIdentityBytes) +
                    " bytes beginning with ANRI",
                "check that this is a ring board and its firmware is current");
  }
  BoardIdentity identity;
  identity.protocol_version = std::to_integer<std::uint8_t>(bytes[4]);
  for (std::size_t i = 0; i < 3; ++i) identity.firmware_version[i] = std::to_integer<std::uint8_t>(bytes[5 + i]);
  identity.serial = GetLittleEndian<std::uint32_t>(bytes.subspan(8));
  identity.first_sensor = GetLittleEndian<std::uint16_t>(bytes.subspan(12));
  identity.sensor_count = std::to_integer<std::uint8_t>(bytes[14]);
  identity.max_level_rate_mhz = GetLittleEndian<std::uint32_t>(bytes.subspan(16));
  identity.min_level_rate_mhz = GetLittleEndian<std::uint32_t>(bytes.subspan(20));
  return identity;
}

std::array<std::byte, 4> EncodeLevelRate(std::uint32_t level_rate_mhz) {
  std::array<std::byte, 4> bytes{};
  PutLittleEndian(std::span<std::byte>(bytes), level_rate_mhz);
  return bytes;
}

Result<std::uint32_t> DecodeLevelRate(std::span<const std::byte> bytes) {
  return DecodeNumber<std::uint32_t>(bytes, "a level rate");
}

std::array<std::byte, 8> EncodeDeviceTime(std::chrono::nanoseconds time) {
  std::array<std::byte, 8> bytes{};
  PutLittleEndian(std::span<std::byte>(bytes), static_cast<std::uint64_t>(time.count()));
  return bytes;
}

Result<std::chrono::nanoseconds> DecodeDeviceTime(std::span<const std::byte> bytes) {
  const auto time = DecodeNumber<std::uint64_t>(bytes, "a board's clock");
  if (!time) return Fail(time);
  if (*time > kLargestTime) return Fail("decode a board's clock", "time below zero", "power-cycle the board");
  return std::chrono::nanoseconds(static_cast<std::int64_t>(*time));
}

}  // namespace annulus
