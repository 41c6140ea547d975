#include <zstd.h>

#include <algorithm>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "acquisition/recording_channels.h"
#include "planted_defects.h"

namespace annulus::test {
namespace {

std::string_view TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A chunk without a look at its CRC.
struct UncheckedChunk {
  std::uint32_t crc = 0;
  std::string records;
};

/// The chunk of a record's content; nothing if it cannot be unpacked.
std::optional<UncheckedChunk> UnpackChunk(std::string_view content) {
  McapCursor cursor(content);
  if (!cursor.TakeRaw(2 * sizeof(std::uint64_t))) return std::nullopt;
  const auto unpacked_bytes = cursor.Take<std::uint64_t>();
  const auto crc = cursor.Take<std::uint32_t>();
  const auto compression = cursor.TakeString();
  const auto records = cursor.TakeString<std::uint64_t>();
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20U;
  if (!records || !crc || !compression || *unpacked_bytes > kMostBytes) return std::nullopt;
  std::string unpacked(*unpacked_bytes, '\0');
  const std::size_t got = ZSTD_decompress(unpacked.data(), unpacked.size(), records->data(), records->size());
  if (ZSTD_isError(got) != 0U || got != unpacked.size()) return std::nullopt;
  return UncheckedChunk{*crc, std::move(unpacked)};
}

/// The content of a chunk record that is not packed and whose CRC is right.
std::string PlainChunk(std::string_view times, const std::string& records) {
  McapBytes chunk;
  chunk.PutRaw(times);
  chunk.Put(static_cast<std::uint64_t>(records.size()));
  chunk.Put(McapCrc(0, std::as_bytes(std::span(records))));
  chunk.PutString("");
  chunk.Put(static_cast<std::uint64_t>(records.size()));
  chunk.PutRaw(records);
  return chunk.bytes();
}

/// The file with the records of every chunk changed by `edit`. A chunk of which the result and the CRC disagree is put
/// back with a CRC that is right; the others stay as they are.
template <class Edit>
std::vector<std::byte> WithChunks(std::span<const std::byte> bytes, Edit edit) {
  const std::string_view file = TextOf(bytes);
  McapBytes out;
  out.PutRaw(file.substr(0, kMcapMagic.size()));
  McapCursor cursor(file.substr(std::min(file.size(), kMcapMagic.size())));
  while (!cursor.rest().empty()) {
    const std::string_view rest = cursor.rest();
    const auto opcode = cursor.Take<std::uint8_t>();
    const auto content = cursor.TakeString<std::uint64_t>();
    if (!content) {
      out.PutRaw(rest);
      break;
    }
    auto chunk = *opcode == static_cast<std::uint8_t>(McapOpcode::kChunk) ? UnpackChunk(*content) : std::nullopt;
    if (chunk) edit(chunk->records);
    if (chunk && McapCrc(0, std::as_bytes(std::span(chunk->records))) != chunk->crc) {
      out.PutRecord(McapOpcode::kChunk, PlainChunk(content->substr(0, 2 * sizeof(std::uint64_t)), chunk->records));
    } else {
      out.PutRaw(rest.substr(0, kMcapRecordHeaderBytes + content->size()));
    }
  }
  const auto result = std::as_bytes(std::span(out.bytes().data(), out.size()));
  return {result.begin(), result.end()};
}

Result<Recording> IgnoresTheCrc(std::span<const std::byte> bytes) {
  return HonestReader(WithChunks(bytes, [](std::string&) {}));
}

/// Overwrites the sequence numbers of the levels with 0, 1, 2, …
Result<Recording> RenumbersLevels(std::span<const std::byte> bytes) {
  std::uint32_t next = 0;
  return HonestReader(WithChunks(bytes, [&](std::string& records) {
    McapCursor cursor(records);
    while (!cursor.rest().empty()) {
      const std::size_t at = records.size() - cursor.rest().size();
      const auto opcode = cursor.Take<std::uint8_t>();
      const auto content = cursor.TakeString<std::uint64_t>();
      if (!content) return;
      McapCursor message(*content);
      const auto channel = message.Take<std::uint16_t>();
      const bool is_level = *opcode == static_cast<std::uint8_t>(McapOpcode::kMessage) &&
                            channel == static_cast<std::uint16_t>(RecordingChannel::kLevels);
      if (!is_level) continue;
      const std::uint32_t sequence = next++;
      std::memcpy(records.data() + at + kMcapRecordHeaderBytes + sizeof(std::uint16_t), &sequence, sizeof sequence);
    }
  }));
}

Result<Recording> StopsAtTheFirstDamage(std::span<const std::byte> bytes) {
  auto read = HonestReader(bytes);
  if (!read) return read;
  std::optional<std::size_t> damage;
  for (const std::string& note : read->report.notes) {
    const std::string start = "at byte ";
    if (!note.starts_with(start)) continue;
    const std::size_t at = std::stoull(note.substr(start.size()));
    damage = std::min(damage.value_or(at), at);
  }
  auto before = HonestReader(bytes.first(std::min(damage.value_or(bytes.size()), bytes.size())));
  return before ? std::move(before) : std::move(read);
}

Result<Recording> CallsDamageWhole(std::span<const std::byte> bytes) {
  auto read = HonestReader(bytes);
  if (!read) return read;
  read->report = RecordingReport();
  read->report.finished = true;
  return read;
}

Result<Recording> DropsTheLastLevel(std::span<const std::byte> bytes) {
  auto read = HonestReader(bytes);
  if (read && !read->report.finished && read->scan.levels.size() > 1) read->scan.levels.pop_back();
  return read;
}

/// Puts the level before it where one is missing.
Result<Recording> FillsGaps(std::span<const std::byte> bytes) {
  auto read = HonestReader(bytes);
  if (!read) return read;
  std::vector<ScanLevel> filled;
  for (ScanLevel& level : read->scan.levels) {
    while (!filled.empty() && filled.back().index + 1 < level.index) {
      filled.push_back(filled.back());
      ++filled.back().index;
    }
    filled.push_back(std::move(level));
  }
  read->scan.levels = std::move(filled);
  return read;
}

Result<bool> SaysNothingWasLost(Storage& storage, const std::string& from, const std::string& to) {
  const auto recovered = HonestRecoverer(storage, from, to);
  if (!recovered) return Fail(recovered);
  return true;
}

Result<bool> EditsTheOriginal(Storage& storage, const std::string& from, const std::string& to) {
  const auto recovered = HonestRecoverer(storage, from, to);
  if (!recovered) return Fail(recovered);
  const auto bytes = storage.ReadAll(to, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  RETURN_IF_ERROR(WriteFileAtomically(storage, from, *bytes));
  return *recovered;
}

Result<bool> CopiesWhatItFinds(Storage& storage, const std::string& from, const std::string& to) {
  const auto bytes = storage.ReadAll(from, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  RETURN_IF_ERROR(WriteFileAtomically(storage, to, *bytes));
  return false;
}

}  // namespace

std::vector<PlantedDefect> DefectiveReaders() {
  return {
      {"a reader without CRC", {.reader = IgnoresTheCrc}},
      {"a reader that renumbers levels", {.reader = RenumbersLevels}},
      {"a reader that stops at the first damage", {.reader = StopsAtTheFirstDamage}},
      {"a reader that calls damage whole", {.reader = CallsDamageWhole}},
      {"a reader that takes the last level for torn", {.reader = DropsTheLastLevel}},
      {"a reader that fills gaps", {.reader = FillsGaps}},
      {"a recovery that says nothing was lost", {.recover = SaysNothingWasLost}},
      {"a recovery that edits the original", {.recover = EditsTheOriginal}},
      {"a recovery that copies damage", {.recover = CopiesWhatItFinds}},
  };
}

}  // namespace annulus::test
