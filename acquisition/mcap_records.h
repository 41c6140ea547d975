#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace annulus {

/// The values of an MCAP file (public specification at mcap.dev/spec, major version 0) that the program uses.
/// All integers are little-endian in the file; times are ns on one clock of the writer's choice.

/// How messages of one kind are described.
struct McapSchema {
  std::uint16_t id = 0;  ///< 1 … 65535.
  std::string name;
  std::string encoding;  ///< "jsonschema".
  std::string data;
};

/// One stream of messages.
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: no schema.
  std::string topic;
  std::string message_encoding;  ///< "json".
  std::map<std::string, std::string> metadata;

  bool operator==(const McapChannel&) const = default;
};

/// One message. `data` borrows: from the caller when written, from the reader's buffer (for the call) when read.
struct McapMessage {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::uint64_t publish_time_ns = 0;
  std::string_view data;
};

/// Named key-value pairs that belong to the whole file.
struct McapMetadata {
  std::string name;
  std::map<std::string, std::string> entries;
};

/// How the records of a chunk are packed.
enum class McapCompression { kNone, kZstd };

/// First and last 8 bytes of every MCAP file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

/// The first byte of a record.
enum class McapOpcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Bytes of a record before its content: opcode and 64-bit length.
inline constexpr std::size_t kMcapRecordHeaderBytes = 9;

/// Continues the CRC-32 (polynomial 0xEDB88320, as zlib) of a file with `bytes`; start with 0.
[[nodiscard]] std::uint32_t McapCrc(std::uint32_t crc, std::span<const std::byte> bytes);

}  // namespace annulus
