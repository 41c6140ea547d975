#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "acquisition/mcap_records.h"
#include "base/result.h"

namespace annulus {

/// Who is told what an MCAP file holds, in file order. Called by ReadMcap only; references live for the call.
class McapListener {
 public:
  virtual ~McapListener() = default;
  virtual void OnMetadata(const McapMetadata& metadata) = 0;
  /// A message of a chunk whose CRC was present and right. Messages that nothing protects are counted, not told.
  virtual void OnMessage(const McapChannel& channel, const McapMessage& message) = 0;
  /// A schema outside the summary. Nothing protects it.
  virtual void OnSchema(const McapSchema& schema) { static_cast<void>(schema); }
  /// All messages of a chunk have been told.
  virtual void OnChunkEnd() {}
};

/// A place where a file is not what it should be.
struct McapDamage {
  std::uint64_t offset = 0;  ///< Bytes from the start of the file.
  std::string what;          ///< Plain words, without the offset.
};

/// What ReadMcap found besides the content.
struct McapReport {
  /// At most this many damages are kept; damage_count goes on.
  static constexpr std::size_t kMaxKept = 100;

  bool finished = false;            ///< Data End, Footer and closing magic are there.
  std::uint64_t chunks = 0;         ///< Chunks read.
  std::uint64_t chunks_lost = 0;    ///< Chunks seen but unreadable.
  std::uint64_t messages = 0;       ///< Messages told to the listener.
  std::uint64_t unprotected = 0;    ///< Messages outside a chunk, or in a chunk without CRC; not told.
  std::uint64_t skipped_bytes = 0;  ///< Belong to no record; at the end: a write that was not complete.
  std::uint64_t damage_count = 0;
  std::vector<McapDamage> damages;  ///< The first kMaxKept.

  /// Whole and undamaged.
  [[nodiscard]] bool clean() const { return finished && damage_count == 0; }
};

/// Bounds of ReadMcap, in bytes.
struct McapLimits {
  std::uint64_t chunk_bytes = std::uint64_t{64} << 20;  ///< Largest unpacked chunk; a larger one is damage.
  std::uint64_t total_bytes = std::uint64_t{8} << 30;   ///< Sum of all unpacked chunks; beyond it reading stops.
};

/// Reads an MCAP file in memory from front to back without trusting its index. A missing end is reported, not an
/// error; a damaged record is skipped by its length if a record follows there, else the next chunk or metadata record
/// is searched for. Fails only if the bytes are not an MCAP file of major version 0; `name` is what messages call it.
/// Memory: one unpacked chunk. Reentrant.
Result<McapReport> ReadMcap(std::span<const std::byte> bytes, const std::string& name, McapListener& listener,
                            const McapLimits& limits = {});

}  // namespace annulus
