#include "acquisition/mcap_writer.h"

#include <zstd.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "base/ensure.h"

namespace annulus {
namespace {

struct FreeCompressor {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

/// Times of the messages of a chunk or file.
struct TimeSpan {
  std::uint64_t first_ns = 0;
  std::uint64_t last_ns = 0;
  bool empty = true;

  void Add(std::uint64_t time_ns) {
    first_ns = empty ? time_ns : std::min(first_ns, time_ns);
    last_ns = empty ? time_ns : std::max(last_ns, time_ns);
    empty = false;
  }
};

/// What the summary says of one chunk.
struct ChunkEntry {
  TimeSpan times;
  std::uint64_t start = 0;
  std::uint64_t length = 0;
  std::map<std::uint16_t, std::uint64_t> index_offsets;
  std::uint64_t index_length = 0;
  std::uint64_t packed_bytes = 0;
  std::uint64_t unpacked_bytes = 0;
};

/// What the summary says of one metadata record.
struct MetadataEntry {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::string name;
};

std::string SchemaContent(const McapSchema& schema) {
  McapBytes content;
  content.Put(schema.id);
  content.PutString(schema.name);
  content.PutString(schema.encoding);
  content.PutString(schema.data);
  return content.bytes();
}

std::string ChannelContent(const McapChannel& channel) {
  McapBytes content;
  content.Put(channel.id);
  content.Put(channel.schema_id);
  content.PutString(channel.topic);
  content.PutString(channel.message_encoding);
  content.PutMap(channel.metadata);
  return content.bytes();
}

std::string_view NameOf(McapCompression compression) { return compression == McapCompression::kZstd ? "zstd" : ""; }

}  // namespace

struct McapWriter::State {
  std::unique_ptr<AppendFile> file;
  McapCompression compression = McapCompression::kZstd;
  std::unique_ptr<ZSTD_CCtx, FreeCompressor> compressor{ZSTD_createCCtx()};
  std::optional<Error> failure;  ///< The first; final.
  std::uint64_t size = 0;
  std::uint32_t data_crc = 0;
  bool started = false;
  bool finished = false;
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<ChunkEntry> chunks;
  std::vector<MetadataEntry> metadata;
  std::map<std::uint16_t, std::uint64_t> message_counts;
  TimeSpan times;

  /// Keeps the first failure of the file.
  Status Latch(Status status) {
    if (!status && !failure) failure = status.error();
    return status;
  }
  Status Check() const {
    ENSURE(!finished, "a finished MCAP file takes no more");
    if (failure) return tl::unexpected<Error>(*failure);
    return {};
  }
  Status Append(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    RETURN_IF_ERROR(Latch(file->Append(bytes)));
    data_crc = McapCrc(data_crc, bytes);
    size += bytes.size();
    return {};
  }
  void PutMetadata(McapBytes& out, const McapMetadata& record);
  std::string Pack(const std::string& records);
  std::string ChannelRecordsOf(std::span<const McapMessage> messages) const;
  std::string Statistics() const;
  std::string Summary(std::uint64_t summary_start) const;
};

void McapWriter::State::PutMetadata(McapBytes& out, const McapMetadata& record) {
  McapBytes content;
  content.PutString(record.name);
  content.PutMap(record.entries);
  metadata.push_back({size + out.size(), kMcapRecordHeaderBytes + content.size(), record.name});
  out.PutRecord(McapOpcode::kMetadata, content.bytes());
}

std::string McapWriter::State::Pack(const std::string& records) {
  if (compression == McapCompression::kNone) return records;
  constexpr int kLevel = 3;
  std::string packed(ZSTD_compressBound(records.size()), '\0');
  const std::size_t length =
      ZSTD_compressCCtx(compressor.get(), packed.data(), packed.size(), records.data(), records.size(), kLevel);
  ENSURE(ZSTD_isError(length) == 0U, "zstd packs into a buffer of its own bound");
  packed.resize(length);
  return packed;
}

std::string McapWriter::State::ChannelRecordsOf(std::span<const McapMessage> messages) const {
  McapBytes records;
  for (const McapChannel& channel : channels) {
    const bool used = std::any_of(messages.begin(), messages.end(),
                                  [&](const McapMessage& message) { return message.channel_id == channel.id; });
    if (used) records.PutRecord(McapOpcode::kChannel, ChannelContent(channel));
  }
  return records.bytes();
}

std::string McapWriter::State::Statistics() const {
  McapBytes statistics;
  std::uint64_t message_count = 0;
  for (const auto& [channel, count] : message_counts) message_count += count;
  statistics.Put(message_count);
  statistics.Put(static_cast<std::uint16_t>(schemas.size()));
  statistics.Put(static_cast<std::uint32_t>(channels.size()));
  statistics.Put(std::uint32_t{0});  // attachments
  statistics.Put(static_cast<std::uint32_t>(metadata.size()));
  statistics.Put(static_cast<std::uint32_t>(chunks.size()));
  statistics.Put(times.first_ns);
  statistics.Put(times.last_ns);
  statistics.PutMap(message_counts);
  return statistics.bytes();
}

/// Everything between Data End and the footer's CRC: groups by opcode, then where each group lies.
std::string McapWriter::State::Summary(std::uint64_t summary_start) const {
  McapBytes out;
  McapBytes offsets;
  std::size_t group_start = 0;
  auto end_group = [&](McapOpcode opcode) {
    if (out.size() == group_start) return;
    McapBytes offset;
    offset.Put(static_cast<std::uint8_t>(opcode));
    offset.Put(summary_start + group_start);
    offset.Put(static_cast<std::uint64_t>(out.size() - group_start));
    offsets.PutRecord(McapOpcode::kSummaryOffset, offset.bytes());
    group_start = out.size();
  };
  for (const McapSchema& schema : schemas) out.PutRecord(McapOpcode::kSchema, SchemaContent(schema));
  end_group(McapOpcode::kSchema);
  for (const McapChannel& channel : channels) out.PutRecord(McapOpcode::kChannel, ChannelContent(channel));
  end_group(McapOpcode::kChannel);
  out.PutRecord(McapOpcode::kStatistics, Statistics());
  end_group(McapOpcode::kStatistics);
  for (const ChunkEntry& chunk : chunks) {
    McapBytes entry;
    entry.Put(chunk.times.first_ns);
    entry.Put(chunk.times.last_ns);
    entry.Put(chunk.start);
    entry.Put(chunk.length);
    entry.PutMap(chunk.index_offsets);
    entry.Put(chunk.index_length);
    entry.PutString(NameOf(compression));
    entry.Put(chunk.packed_bytes);
    entry.Put(chunk.unpacked_bytes);
    out.PutRecord(McapOpcode::kChunkIndex, entry.bytes());
  }
  end_group(McapOpcode::kChunkIndex);
  for (const MetadataEntry& record : metadata) {
    McapBytes entry;
    entry.Put(record.offset);
    entry.Put(record.length);
    entry.PutString(record.name);
    out.PutRecord(McapOpcode::kMetadataIndex, entry.bytes());
  }
  end_group(McapOpcode::kMetadataIndex);
  const std::uint64_t summary_offset_start = summary_start + out.size();
  out.PutRaw(offsets.bytes());
  constexpr std::uint64_t kFooterBytes = 20;
  out.Put(static_cast<std::uint8_t>(McapOpcode::kFooter));
  out.Put(kFooterBytes);
  out.Put(summary_start);
  out.Put(summary_offset_start);
  return out.bytes();
}

McapWriter::McapWriter(std::unique_ptr<AppendFile> file, McapCompression compression)
    : state_(std::make_unique<State>()) {
  ENSURE(file != nullptr, "an MCAP file is written to a file");
  ENSURE(state_->compressor != nullptr, "zstd has memory for a compressor");
  state_->file = std::move(file);
  state_->compression = compression;
}
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;
McapWriter::~McapWriter() = default;

Status McapWriter::WritePreamble(McapPreamble preamble) {
  RETURN_IF_ERROR(state_->Check());
  ENSURE(!state_->started, "the preamble is written once");
  state_->started = true;
  McapBytes out;
  out.PutRaw(kMcapMagic);
  McapBytes header;
  header.PutString(preamble.profile);
  header.PutString(preamble.library);
  out.PutRecord(McapOpcode::kHeader, header.bytes());
  for (std::size_t i = 0; i < preamble.metadata.size(); ++i) {
    state_->PutMetadata(out, preamble.metadata[i]);
    if (i > 0) continue;
    RETURN_IF_ERROR(state_->Append(out.bytes()));
    out = {};
  }
  for (const McapSchema& schema : preamble.schemas) out.PutRecord(McapOpcode::kSchema, SchemaContent(schema));
  for (const McapChannel& channel : preamble.channels) out.PutRecord(McapOpcode::kChannel, ChannelContent(channel));
  state_->schemas = std::move(preamble.schemas);
  state_->channels = std::move(preamble.channels);
  return state_->Append(out.bytes());
}

Status McapWriter::WriteChunk(std::span<const McapMessage> messages) {
  RETURN_IF_ERROR(state_->Check());
  ENSURE(state_->started && !messages.empty(), "a chunk follows the preamble and has messages");
  McapBytes records;
  records.PutRaw(state_->ChannelRecordsOf(messages));
  ChunkEntry entry;
  std::map<std::uint16_t, McapBytes> index;
  for (const McapMessage& message : messages) {
    index[message.channel_id].Put(message.log_time_ns);
    index[message.channel_id].Put(static_cast<std::uint64_t>(records.size()));
    entry.times.Add(message.log_time_ns);
    McapBytes content;
    content.Put(message.channel_id);
    content.Put(message.sequence);
    content.Put(message.log_time_ns);
    content.Put(message.publish_time_ns);
    content.PutRaw(message.data);
    records.PutRecord(McapOpcode::kMessage, content.bytes());
  }
  const std::string packed = state_->Pack(records.bytes());
  McapBytes chunk;
  chunk.Put(entry.times.first_ns);
  chunk.Put(entry.times.last_ns);
  chunk.Put(static_cast<std::uint64_t>(records.size()));
  chunk.Put(McapCrc(0, std::as_bytes(std::span(records.bytes().data(), records.size()))));
  chunk.PutString(NameOf(state_->compression));
  chunk.Put(static_cast<std::uint64_t>(packed.size()));
  chunk.PutRaw(packed);
  McapBytes out;
  out.PutRecord(McapOpcode::kChunk, chunk.bytes());
  entry.start = state_->size;
  entry.length = out.size();
  entry.packed_bytes = packed.size();
  entry.unpacked_bytes = records.size();
  for (const auto& [channel, offsets] : index) {
    entry.index_offsets[channel] = state_->size + out.size();
    McapBytes content;
    content.Put(channel);
    content.PutString(offsets.bytes());
    out.PutRecord(McapOpcode::kMessageIndex, content.bytes());
  }
  entry.index_length = out.size() - entry.length;
  RETURN_IF_ERROR(state_->Append(out.bytes()));
  for (const McapMessage& message : messages) {
    ++state_->message_counts[message.channel_id];
    state_->times.Add(message.log_time_ns);
  }
  state_->chunks.push_back(std::move(entry));
  return {};
}

Status McapWriter::WriteMetadata(const McapMetadata& metadata) {
  RETURN_IF_ERROR(state_->Check());
  ENSURE(state_->started, "metadata follows the preamble");
  McapBytes out;
  state_->PutMetadata(out, metadata);
  return state_->Append(out.bytes());
}

Status McapWriter::Finish() {
  RETURN_IF_ERROR(state_->Check());
  ENSURE(state_->started, "a file begins before it ends");
  McapBytes data_end;
  data_end.Put(state_->data_crc);
  McapBytes out;
  out.PutRecord(McapOpcode::kDataEnd, data_end.bytes());
  const std::string summary = state_->Summary(state_->size + out.size());
  out.PutRaw(summary);
  out.Put(McapCrc(0, std::as_bytes(std::span(summary.data(), summary.size()))));
  out.PutRaw(kMcapMagic);
  RETURN_IF_ERROR(state_->Append(out.bytes()));
  RETURN_IF_ERROR(Sync());
  state_->finished = true;
  return state_->Latch(state_->file->Close());
}

Status McapWriter::Sync() {
  RETURN_IF_ERROR(state_->Check());
  return state_->Latch(state_->file->Sync());
}

Status McapWriter::Reserve(std::uint64_t bytes) {
  RETURN_IF_ERROR(state_->Check());
  return state_->Latch(state_->file->Reserve(bytes));
}

std::uint64_t McapWriter::size_bytes() const { return state_->size; }

}  // namespace annulus
