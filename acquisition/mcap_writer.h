#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquisition/mcap_records.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// What stands before the first message of a file.
struct McapPreamble {
  std::string profile;
  std::string library;
  std::vector<McapMetadata> metadata;
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;  ///< Every channel that WriteChunk uses.
};

/// Writes an MCAP file front to back. Every call is one Append of the file, so that a torn write costs that call only
/// (WritePreamble: two, the first one with the first metadata record, so that a lost block does not cost both copies);
/// what stands in the file can be read without Finish(). Memory: one chunk, and 70 bytes per chunk for the index.
/// A failed call latches: later calls repeat its error. Thread-bound.
class McapWriter {
 public:
  /// Takes a new, empty file.
  McapWriter(std::unique_ptr<AppendFile> file, McapCompression compression);
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  ~McapWriter();

  /// Magic, Header, Metadata, Schemas, Channels. Exactly once, first.
  Status WritePreamble(McapPreamble preamble);
  /// One Chunk with `messages` and a copy of their Channel records (so that it can be read if the preamble is damaged),
  /// and its Message Index records. At least one message; channels of the preamble only.
  Status WriteChunk(std::span<const McapMessage> messages);
  /// One Metadata record.
  Status WriteMetadata(const McapMetadata& metadata);
  /// Data End, summary, Footer, magic; then syncs and closes. Nothing may be called afterwards.
  Status Finish();
  /// Data to the disk.
  Status Sync();
  /// Reserves `bytes` more on the disk.
  Status Reserve(std::uint64_t bytes);

  /// Bytes appended so far.
  [[nodiscard]] std::uint64_t size_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace annulus
