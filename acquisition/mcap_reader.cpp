#include "acquisition/mcap_reader.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "base/ensure.h"

namespace annulus {
namespace {

std::uint32_t CrcOf(std::string_view text) { return McapCrc(0, std::as_bytes(std::span(text.data(), text.size()))); }

/// The fields of a Chunk record; `records` are still packed.
struct ChunkFields {
  std::uint64_t unpacked_bytes = 0;
  std::uint32_t crc = 0;
  std::string_view compression;
  std::string_view records;
  std::string_view surplus;  ///< Content after the known fields.
};

std::optional<ChunkFields> ParseChunk(std::string_view content) {
  McapCursor cursor(content);
  if (!cursor.TakeRaw(2 * sizeof(std::uint64_t))) return std::nullopt;  // times: the messages say them again
  const auto unpacked_bytes = cursor.Take<std::uint64_t>();
  const auto crc = cursor.Take<std::uint32_t>();
  const auto compression = cursor.TakeString();
  const auto records = cursor.TakeString<std::uint64_t>();
  if (!unpacked_bytes || !crc || !compression || !records) return std::nullopt;
  return ChunkFields{*unpacked_bytes, *crc, *compression, *records, cursor.rest()};
}

/// A serialised map of texts, whole; nothing if it does not fill `bytes` exactly.
std::optional<std::map<std::string, std::string>> ParseMap(std::string_view bytes) {
  std::map<std::string, std::string> entries;
  McapCursor cursor(bytes);
  while (!cursor.rest().empty()) {
    const auto key = cursor.TakeString();
    const auto value = cursor.TakeString();
    if (!key || !value) return std::nullopt;
    entries.emplace(*key, *value);
  }
  return entries;
}

/// A record's content as a value, and what follows the known fields.
template <class Value>
struct Parsed {
  Value value;
  std::string_view surplus;
};

std::optional<Parsed<McapMetadata>> ParseMetadata(std::string_view content) {
  McapCursor cursor(content);
  const auto name = cursor.TakeString();
  const auto map_bytes = cursor.TakeString();
  if (!name || !map_bytes) return std::nullopt;
  auto entries = ParseMap(*map_bytes);
  if (!entries) return std::nullopt;
  return Parsed<McapMetadata>{{std::string(*name), std::move(*entries)}, cursor.rest()};
}

std::optional<Parsed<McapChannel>> ParseChannel(std::string_view content) {
  McapCursor cursor(content);
  const auto id = cursor.Take<std::uint16_t>();
  const auto schema_id = cursor.Take<std::uint16_t>();
  const auto topic = cursor.TakeString();
  const auto encoding = cursor.TakeString();
  const auto map_bytes = cursor.TakeString();
  if (!id || !schema_id || !topic || !encoding || !map_bytes) return std::nullopt;
  auto metadata = ParseMap(*map_bytes);
  if (!metadata) return std::nullopt;
  return Parsed<McapChannel>{{*id, *schema_id, std::string(*topic), std::string(*encoding), std::move(*metadata)},
                             cursor.rest()};
}

std::optional<Parsed<McapSchema>> ParseSchema(std::string_view content) {
  McapCursor cursor(content);
  const auto id = cursor.Take<std::uint16_t>();
  const auto name = cursor.TakeString();
  const auto encoding = cursor.TakeString();
  const auto data = cursor.TakeString();
  if (!id || !name || !encoding || !data) return std::nullopt;
  return Parsed<McapSchema>{{*id, std::string(*name), std::string(*encoding), std::string(*data)}, cursor.rest()};
}

std::optional<McapMessage> ParseMessage(std::string_view content) {
  McapCursor cursor(content);
  const auto channel = cursor.Take<std::uint16_t>();
  const auto sequence = cursor.Take<std::uint32_t>();
  const auto log_time = cursor.Take<std::uint64_t>();
  const auto publish_time = cursor.Take<std::uint64_t>();
  if (!channel || !sequence || !log_time || !publish_time) return std::nullopt;
  return McapMessage{*channel, *sequence, *log_time, *publish_time, cursor.rest()};
}

/// One record as it lies in the file.
struct RawRecord {
  std::uint8_t opcode = 0;
  std::string_view content;
};

std::optional<RawRecord> RecordAt(std::string_view bytes, std::size_t offset) {
  McapCursor cursor(bytes.substr(offset));
  const auto opcode = cursor.Take<std::uint8_t>();
  const auto content = opcode ? cursor.TakeString<std::uint64_t>() : std::nullopt;
  if (!content) return std::nullopt;
  return RawRecord{*opcode, *content};
}

bool Is(const RawRecord& record, McapOpcode opcode) { return record.opcode == static_cast<std::uint8_t>(opcode); }

struct FreeDecompressor {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// One pass over a file.
class McapPass {
 public:
  McapPass(std::string_view file, McapListener& listener, const McapLimits& limits)
      : file_(file), listener_(listener), limits_(limits) {}

  McapReport Run();

 private:
  /// How a record was found to be.
  enum class Outcome { kGood, kDamaged, kEnd };

  Outcome Handle(const RawRecord& record);
  Outcome HandleInData(const RawRecord& record);
  Outcome HandleChunk(std::string_view content);
  Outcome HandleDataEnd(std::string_view content);
  Outcome HandleFooter(std::string_view content);
  void HandleRecordsOfChunk(std::string_view records);
  std::optional<std::string_view> Unpack(const ChunkFields& chunk);
  Outcome AcceptSurplus(std::string_view surplus);
  [[nodiscard]] bool RecordFollows(std::size_t offset) const;
  [[nodiscard]] std::size_t FindRecord(std::size_t begin, std::size_t end) const;
  void Note(std::string what);

  /// Bytes of metadata that searches parse at most, so that a hostile file cannot make them quadratic.
  static constexpr std::uint64_t kSearchBudget = std::uint64_t{256} << 20;

  std::string_view file_;
  McapListener& listener_;
  McapLimits limits_;
  McapReport report_;
  std::size_t offset_ = 0;         ///< Of the record at hand.
  std::size_t next_ = 0;           ///< Of the record after it.
  std::size_t summary_start_ = 0;  ///< After Data End; 0 before it.
  std::map<std::uint16_t, McapChannel> channels_;
  mutable std::uint64_t search_budget_ = kSearchBudget;
  std::unique_ptr<ZSTD_DCtx, FreeDecompressor> decompressor_;  ///< Made by the first packed chunk.
  std::unique_ptr<char[]> unpacked_;
  std::uint64_t unpacked_capacity_ = 0;
  std::uint64_t unpacked_total_ = 0;
};

void McapPass::Note(std::string what) {
  ++report_.damage_count;
  if (report_.damages.size() < McapReport::kMaxKept) report_.damages.push_back({offset_, std::move(what)});
}

bool McapPass::RecordFollows(std::size_t offset) const {
  if (offset == file_.size()) return true;
  const auto record = RecordAt(file_, offset);
  return record && record->opcode >= static_cast<std::uint8_t>(McapOpcode::kHeader) &&
         record->opcode <= static_cast<std::uint8_t>(McapOpcode::kDataEnd);
}

/// The first offset in [begin, end) where a Chunk or Metadata record stands whose inner lengths all agree; else `end`.
std::size_t McapPass::FindRecord(std::size_t begin, std::size_t end) const {
  constexpr char kStarts[] = {static_cast<char>(McapOpcode::kChunk), static_cast<char>(McapOpcode::kMetadata)};
  const std::string_view starts(kStarts, sizeof kStarts);
  const std::string_view searched = file_.substr(0, end);
  for (std::size_t at = searched.find_first_of(starts, begin); at < end; at = searched.find_first_of(starts, at + 1)) {
    const auto record = RecordAt(file_, at);
    if (!record) continue;
    if (Is(*record, McapOpcode::kChunk)) {
      const auto chunk = ParseChunk(record->content);
      if (chunk && chunk->surplus.empty() && chunk->unpacked_bytes <= limits_.chunk_bytes) return at;
    } else if (record->content.size() <= search_budget_) {
      search_budget_ -= record->content.size();
      const auto metadata = ParseMetadata(record->content);
      if (metadata && metadata->surplus.empty() && !metadata->value.name.empty()) return at;
    }
  }
  return end;
}

McapReport McapPass::Run() {
  if (!file_.starts_with(kMcapMagic)) Note("one of the first 8 bytes is wrong");
  next_ = kMcapMagic.size();
  while (next_ < file_.size()) {
    offset_ = next_;
    const auto record = RecordAt(file_, offset_);
    if (!record) {
      next_ = FindRecord(offset_ + 1, file_.size());
      report_.skipped_bytes += next_ - offset_;
      Note(next_ < file_.size() ? "a record's length is wrong; skipped " + std::to_string(next_ - offset_) + " bytes"
                                : "the file ends within a record");
      continue;
    }
    next_ = offset_ + kMcapRecordHeaderBytes + record->content.size();
    const Outcome outcome = Handle(*record);
    if (outcome == Outcome::kEnd) return report_;
    if (outcome == Outcome::kDamaged && !RecordFollows(next_)) next_ = FindRecord(offset_ + 1, file_.size());
  }
  offset_ = file_.size();
  if (report_.damage_count == 0) Note("the end of the file is missing");
  return report_;
}

McapPass::Outcome McapPass::Handle(const RawRecord& record) {
  if (Is(record, McapOpcode::kFooter)) return HandleFooter(record.content);
  if (summary_start_ != 0) {
    if (!Is(record, McapOpcode::kChunk)) return Outcome::kGood;  // the summary repeats; its CRC is checked
    Note("data follows the record that ends the data");
    summary_start_ = 0;
  }
  return HandleInData(record);
}

McapPass::Outcome McapPass::HandleInData(const RawRecord& record) {
  switch (static_cast<McapOpcode>(record.opcode)) {
    case McapOpcode::kChunk:
      return HandleChunk(record.content);
    case McapOpcode::kDataEnd:
      return HandleDataEnd(record.content);
    case McapOpcode::kMetadata: {
      const auto metadata = ParseMetadata(record.content);
      if (!metadata) break;
      listener_.OnMetadata(metadata->value);
      return AcceptSurplus(metadata->surplus);
    }
    case McapOpcode::kChannel: {
      const auto channel = ParseChannel(record.content);
      if (!channel) break;
      channels_.emplace(channel->value.id, channel->value);
      return AcceptSurplus(channel->surplus);
    }
    case McapOpcode::kMessage:
      ++report_.unprotected;
      return AcceptSurplus(record.content);
    case McapOpcode::kSchema: {
      const auto schema = ParseSchema(record.content);
      if (schema) listener_.OnSchema(schema->value);
      return AcceptSurplus(record.content);
    }
    case McapOpcode::kHeader:
    case McapOpcode::kMessageIndex:
      return AcceptSurplus(record.content);
    case McapOpcode::kAttachment:
      return Outcome::kGood;
    default:
      if (record.opcode >= 0x80) return Outcome::kGood;  // private records of other programs
      break;
  }
  Note("a record of kind " + std::to_string(record.opcode) + " is damaged or does not belong there");
  return Outcome::kDamaged;
}

/// Content that is not looked at. A wrong length may have made it swallow the records after it: they are found.
McapPass::Outcome McapPass::AcceptSurplus(std::string_view surplus) {
  const std::size_t begin = next_ - surplus.size();
  const std::size_t found = FindRecord(begin, next_);
  if (found < next_) {
    Note("a record's length is wrong: other records lie inside it");
    next_ = found;
  }
  return Outcome::kGood;
}

std::optional<std::string_view> McapPass::Unpack(const ChunkFields& chunk) {
  if (chunk.unpacked_bytes > limits_.chunk_bytes) {
    Note("a chunk says that it unpacks to " + std::to_string(chunk.unpacked_bytes) + " bytes");
    return std::nullopt;
  }
  unpacked_total_ += chunk.unpacked_bytes;
  if (chunk.compression.empty()) {
    if (chunk.records.size() == chunk.unpacked_bytes) return chunk.records;
    Note("a chunk's sizes contradict each other");
    return std::nullopt;
  }
  if (chunk.compression != "zstd") {
    Note("a chunk is packed by something else than zstd");
    return std::nullopt;
  }
  if (ZSTD_getFrameContentSize(chunk.records.data(), chunk.records.size()) != chunk.unpacked_bytes) {
    Note("a chunk's sizes contradict each other");
    return std::nullopt;
  }
  if (chunk.unpacked_bytes > unpacked_capacity_) {
    unpacked_ = std::make_unique_for_overwrite<char[]>(chunk.unpacked_bytes);
    unpacked_capacity_ = chunk.unpacked_bytes;
  }
  if (!decompressor_) decompressor_.reset(ZSTD_createDCtx());
  ENSURE(decompressor_ != nullptr, "zstd has memory to unpack");
  const std::size_t got = ZSTD_decompressDCtx(decompressor_.get(), unpacked_.get(), chunk.unpacked_bytes,
                                              chunk.records.data(), chunk.records.size());
  if (ZSTD_isError(got) != 0U || got != chunk.unpacked_bytes) {
    Note("a chunk cannot be unpacked");
    return std::nullopt;
  }
  return std::string_view(unpacked_.get(), got);
}

McapPass::Outcome McapPass::HandleChunk(std::string_view content) {
  const auto chunk = ParseChunk(content);
  if (!chunk) {
    ++report_.chunks_lost;
    Note("a chunk's lengths contradict each other");
    return Outcome::kDamaged;
  }
  const auto records = Unpack(*chunk);
  if (unpacked_total_ > limits_.total_bytes) {
    Note("its chunks unpack to more than " + std::to_string(limits_.total_bytes) + " bytes; the rest was not read");
    return Outcome::kEnd;
  }
  const bool right = records && (chunk->crc == 0 || CrcOf(*records) == chunk->crc);
  if (!right) {
    if (records) Note("a chunk's CRC is wrong");
    ++report_.chunks_lost;
    return Outcome::kDamaged;
  }
  ++report_.chunks;
  if (chunk->crc == 0 && !records->empty()) {
    ++report_.unprotected;
  } else {
    HandleRecordsOfChunk(*records);
    listener_.OnChunkEnd();
  }
  return AcceptSurplus(chunk->surplus);
}

void McapPass::HandleRecordsOfChunk(std::string_view records) {
  for (std::size_t at = 0; at < records.size();) {
    const auto record = RecordAt(records, at);
    if (!record) return Note("a chunk holds a record that ends outside it");
    at += kMcapRecordHeaderBytes + record->content.size();
    if (Is(*record, McapOpcode::kChannel)) {
      const auto channel = ParseChannel(record->content);
      if (!channel) return Note("a chunk holds a damaged channel");
      channels_.insert_or_assign(channel->value.id, channel->value);
    } else if (Is(*record, McapOpcode::kMessage)) {
      const auto message = ParseMessage(record->content);
      if (!message) return Note("a chunk holds a message that is too short");
      const auto channel = channels_.find(message->channel_id);
      if (channel == channels_.end()) return Note("a message belongs to a channel that is not described");
      ++report_.messages;
      listener_.OnMessage(channel->second, *message);
    }
  }
}

McapPass::Outcome McapPass::HandleDataEnd(std::string_view content) {
  McapCursor cursor(content);
  const auto crc = cursor.Take<std::uint32_t>();
  if (!crc || !cursor.rest().empty()) {
    Note("the record that ends the data has a wrong length");
    return Outcome::kDamaged;
  }
  summary_start_ = next_;
  if (*crc != 0 && *crc != CrcOf(file_.substr(0, offset_))) Note("the CRC over all data is wrong");
  return Outcome::kGood;
}

McapPass::Outcome McapPass::HandleFooter(std::string_view content) {
  McapCursor cursor(content);
  const auto start = cursor.Take<std::uint64_t>();
  const auto offset_start = cursor.Take<std::uint64_t>();
  const auto crc = cursor.Take<std::uint32_t>();
  if (!start || !offset_start || !crc || !cursor.rest().empty()) {
    Note("the footer has a wrong length");
    return Outcome::kDamaged;
  }
  if (*start != 0 && *start != summary_start_) {
    Note("the footer points to a wrong place");
  } else if (*start != 0 && *crc != 0) {
    const std::size_t end = next_ - sizeof(std::uint32_t);
    if (CrcOf(file_.substr(summary_start_, end - summary_start_)) != *crc) Note("the summary's CRC is wrong");
  }
  if (file_.substr(next_) != kMcapMagic) {
    Note("the closing bytes are wrong");
    return Outcome::kEnd;
  }
  report_.finished = summary_start_ != 0 || *start == 0;
  if (!report_.finished) Note("the record that ends the data is missing");
  return Outcome::kEnd;
}

/// How many of the 8 first bytes are those of an MCAP file. One wrong byte is taken for damage.
std::size_t RightMagicBytes(std::string_view file) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < std::min(file.size(), kMcapMagic.size()); ++i) {
    if (file[i] == kMcapMagic[i]) ++right;
  }
  return right;
}

/// The first bytes of a foreign file in words.
std::string DescribeStart(std::string_view file) {
  constexpr std::size_t kShown = 8;
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text = "its first bytes are";
  for (const char c : file.substr(0, kShown)) {
    const auto byte = static_cast<unsigned char>(c);
    text += {' ', kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return text + ", not those of an MCAP file";
}

}  // namespace

Result<McapReport> ReadMcap(std::span<const std::byte> bytes, const std::string& name, McapListener& listener,
                            const McapLimits& limits) {
  const std::string attempted = "read " + name;
  const std::string advice = "give a recording that this program wrote";
  const std::string_view file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (file.empty()) return Fail(attempted, "it is empty", advice);
  const std::size_t right = RightMagicBytes(file);
  constexpr std::size_t kVersionAt = 5;
  if (right + 1 == kMcapMagic.size() && file[kVersionAt] != kMcapMagic[kVersionAt]) {
    return Fail(attempted, "it is an MCAP file of another version", "give a file of MCAP version 0");
  }
  if (right + 1 < kMcapMagic.size()) return Fail(attempted, DescribeStart(file), advice);
  return McapPass(file, listener, limits).Run();
}

}  // namespace annulus
