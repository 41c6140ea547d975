#include "acquisition/recording_recovery.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "acquisition/mcap_reader.h"
#include "acquisition/mcap_writer.h"
#include "acquisition/recording_channels.h"
#include "acquisition/recording_names.h"
#include "base/ensure.h"
#include "base/sha256.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Entries = std::map<std::string, std::string>;

/// In the name of a copy while it is written.
constexpr std::string_view kCopyMark = ".recover-copy";

std::string EntryOf(const Entries& entries, const char* key) {
  const auto found = entries.find(key);
  return found == entries.end() ? std::string() : found->second;
}

bool IsOurTopic(std::string_view topic) {
  return std::any_of(kRecordingChannels.begin(), kRecordingChannels.end(),
                     [&](RecordingChannel channel) { return TopicOf(channel) == topic; });
}

/// First pass: what the new file must begin and end with.
class Survey final : public McapListener {
 public:
  void OnMetadata(const McapMetadata& metadata) override {
    const Entries& entries = metadata.entries;
    if (metadata.name == kScanRecordName) {
      const std::string json = EntryOf(entries, kJsonKey);
      if (header_json || Sha256OfText(json) != EntryOf(entries, kSha256Key)) return;
      header_json = json;
      recording_id = RecordingId(json);
    } else if (metadata.name == kEndRecordName) {
      const std::string text =
          EntryOf(entries, kLevelCountKey) + EntryOf(entries, kScanHashKey) + EntryOf(entries, kMessageCountsKey);
      if (Sha256OfText(text) == EntryOf(entries, kSha256Key) && IsOfRecording(entries, recording_id)) end = entries;
    } else if (metadata.name == kRecoveryRecordName) {
      if (Sha256OfText(EntryOf(entries, kJsonKey)) == EntryOf(entries, kSha256Key)) recovery = entries;
    } else {
      others.push_back(metadata);
    }
  }
  void OnSchema(const McapSchema& schema) override { schemas_.emplace(schema.id, schema); }
  void OnMessage(const McapChannel& channel, const McapMessage& message) override {
    if (!IsOfRecording(channel.metadata, recording_id)) return;
    std::uint64_t& next = next_sequence[channel.topic];
    next = std::max(next, std::uint64_t{message.sequence} + 1);
    if (IsOurTopic(channel.topic) || foreign_.size() == kMaxForeign || !topics_.insert(channel.topic).second) return;
    foreign_.push_back(channel);
  }

  /// The preamble of the new file: ours, and the channels that we do not know.
  [[nodiscard]] McapPreamble Preamble(const std::string& program_version) const {
    McapPreamble preamble = RecordingPreamble(*header_json, program_version);
    std::uint16_t id = kFirstForeignId;
    for (McapChannel channel : foreign_) {
      const auto schema = schemas_.find(channel.schema_id);
      channel.id = id;
      channel.schema_id = schema == schemas_.end() ? std::uint16_t{0} : id;
      preamble.channels.push_back(channel);
      if (schema != schemas_.end()) {
        preamble.schemas.push_back({id, schema->second.name, schema->second.encoding, schema->second.data});
      }
      ++id;
    }
    return preamble;
  }

  std::optional<std::string> header_json;
  std::string recording_id;
  std::optional<Entries> end;
  std::optional<Entries> recovery;                     ///< Of a recovery before this one.
  std::vector<McapMetadata> others;                    ///< Of a kind that we do not know.
  std::map<std::string, std::uint64_t> next_sequence;  ///< By topic: after the last message.

 private:
  static constexpr std::uint16_t kFirstForeignId = 100;
  static constexpr std::size_t kMaxForeign = 1'000;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::set<std::string> topics_;
  std::vector<McapChannel> foreign_;  ///< In the order of their first messages.
};

/// SHA-256 over messages: topic, sequence, time and content. Says whether two files hold the same.
class MessageDigest final : public McapListener {
 public:
  void OnMetadata(const McapMetadata&) override {}
  void OnMessage(const McapChannel& channel, const McapMessage& message) override { Add(channel.topic, message); }
  void Add(std::string_view topic, const McapMessage& message) {
    McapBytes bytes;
    bytes.PutString(topic);
    bytes.Put(message.sequence);
    bytes.Put(message.log_time_ns);
    bytes.Put(message.publish_time_ns);
    bytes.PutString(message.data);
    hash_.Update(std::as_bytes(std::span(bytes.bytes().data(), bytes.size())));
  }
  [[nodiscard]] std::string Hex() { return hash_.Hex(); }

 private:
  Sha256 hash_;
};

/// Second pass: every chunk of the old file becomes one of the new file.
class Copier final : public McapListener {
 public:
  Copier(McapWriter& writer, const McapPreamble& preamble, std::string recording_id)
      : writer_(writer), recording_id_(std::move(recording_id)) {
    for (const McapChannel& channel : preamble.channels) ids_[channel.topic] = channel.id;
  }
  void OnMetadata(const McapMetadata&) override {}
  void OnMessage(const McapChannel& channel, const McapMessage& message) override {
    const auto id = ids_.find(channel.topic);
    if (id == ids_.end() || !IsOfRecording(channel.metadata, recording_id_)) return;
    std::uint64_t& next = next_[channel.topic];
    if (message.sequence < next) return;  // stands twice in the file
    next = std::uint64_t{message.sequence} + 1;
    McapMessage copy = message;
    copy.channel_id = id->second;
    messages_.push_back(copy);
    digest_.Add(channel.topic, copy);
  }
  void OnChunkEnd() override {
    if (status_ && !messages_.empty()) status_ = writer_.WriteChunk(messages_);
    messages_.clear();
  }
  [[nodiscard]] const Status& status() const { return status_; }
  [[nodiscard]] std::string Digest() { return digest_.Hex(); }

 private:
  McapWriter& writer_;
  std::string recording_id_;
  std::map<std::string, std::uint16_t> ids_;
  std::map<std::string, std::uint64_t> next_;
  std::vector<McapMessage> messages_;  ///< Borrow from the reader's chunk, until its end.
  MessageDigest digest_;
  Status status_;
};

/// A recording to be saved, opened.
struct Source {
  std::string name;
  std::vector<std::byte> bytes;  ///< Plain.
  std::optional<Seal> seal;      ///< For the new file.
  Recording recording;
  Survey survey;
  McapReport report;
  std::uint64_t skipped_bytes = 0;  ///< Of the seal: no genuine frame.
};

Result<Source> OpenSource(std::vector<std::byte> bytes, const std::string& name, const KeySource* keys) {
  Source source;
  source.name = name;
  std::vector<std::string> seal_notes;
  std::uint64_t frames_lost = 0;
  if (LooksSealed(bytes)) {
    auto unsealed = UnsealRecording(bytes, name, keys);
    if (!unsealed) return Fail(unsealed);
    const auto key = keys->Key(unsealed->key_id);
    if (!key) return Fail(key);
    source.seal = Seal{unsealed->key_id, *key, RandomSealedFileId()};
    seal_notes = std::move(unsealed->notes);
    frames_lost = unsealed->frames_lost;
    source.skipped_bytes = unsealed->skipped_bytes;
    bytes = std::move(unsealed->bytes);
  }
  source.bytes = std::move(bytes);
  auto recording = ParseRecording(source.bytes, name);
  if (!recording) return Fail(recording);
  source.recording = std::move(*recording);
  RecordingReport& report = source.recording.report;
  report.notes.insert(report.notes.begin(), seal_notes.begin(), seal_notes.end());
  report.sealed = source.seal.has_value();
  report.frames_lost = frames_lost;
  auto mcap = ReadMcap(source.bytes, name, source.survey);
  if (!mcap) return Fail(mcap);
  source.report = std::move(*mcap);
  ENSURE(source.survey.header_json.has_value(), "a recording that was read has a header");
  return source;
}

/// Losses that an earlier recovery has noted already.
std::map<std::string, std::uint64_t> KnownLosses(const Survey& survey) {
  std::map<std::string, std::uint64_t> known;
  if (!survey.recovery) return known;
  const Json json = Json::parse(EntryOf(*survey.recovery, kJsonKey), nullptr, false);
  if (!json.is_object() || !json.contains("messages_lost")) return known;
  for (const auto& [topic, count] : json["messages_lost"].items()) {
    if (count.is_number_unsigned()) known[topic] = count.get<std::uint64_t>();
  }
  return known;
}

RecoverySummary Summarise(const Source& source) {
  const RecordingReport& report = source.recording.report;
  RecoverySummary summary;
  summary.was_finished = report.finished;
  summary.sealed = report.sealed;
  summary.levels = source.recording.scan.levels.size();
  summary.messages = report.messages;
  summary.messages_lost = report.messages_lost;
  summary.chunks_lost = source.report.chunks_lost;
  summary.frames_lost = report.frames_lost;
  summary.skipped_bytes = source.report.skipped_bytes + source.skipped_bytes;
  summary.unprotected = source.report.unprotected;
  summary.notes = report.notes;
  const auto known = KnownLosses(source.survey);
  bool missing = false;
  for (const auto& [topic, count] : report.messages_lost) {
    const auto found = known.find(topic);
    if (count > (found == known.end() ? 0 : found->second)) missing = true;
  }
  // With the numbers of all messages known, damage that cost none of them is no loss.
  const bool counted = source.survey.end && !EntryOf(*source.survey.end, kMessageCountsKey).empty();
  const bool damaged = summary.chunks_lost > 0 || summary.frames_lost > 0 || summary.skipped_bytes > 0;
  summary.lossless = !missing && summary.unprotected == 0 && (counted || !damaged);
  return summary;
}

Json LossesJson(const RecoverySummary& summary) {
  Json lost = Json::object();
  for (const auto& [topic, count] : summary.messages_lost) lost[topic] = count;
  return {{"was_finished", summary.was_finished},   {"messages_lost", lost},
          {"chunks_lost", summary.chunks_lost},     {"frames_lost", summary.frames_lost},
          {"skipped_bytes", summary.skipped_bytes}, {"unprotected", summary.unprotected}};
}

/// The end record: as it was, or that of a scan which never came to its end.
Entries EndOf(const Source& source) {
  if (source.survey.end) return *source.survey.end;
  Json counts = Json::object();
  for (const RecordingChannel channel : kRecordingChannels) {
    const auto found = source.survey.next_sequence.find(std::string(TopicOf(channel)));
    if (found != source.survey.next_sequence.end()) counts[found->first] = found->second;
  }
  const auto levels = source.survey.next_sequence.find(std::string(kLevelsTopic));
  const std::string count = std::to_string(levels == source.survey.next_sequence.end() ? 0 : levels->second);
  const std::string hash = ScanHash(source.recording.scan);
  const std::string messages = counts.dump();
  return {{kLevelCountKey, count},
          {kScanHashKey, hash},
          {kMessageCountsKey, messages},
          {kRecordingKey, source.survey.recording_id},
          {kSha256Key, Sha256OfText(count + hash + messages)}};
}

/// Writes the new file; returns the digest of its messages.
Result<std::string> WriteCopy(Storage& storage, const std::string& path, const Source& source,
                              const RecoverySummary& summary) {
  auto file = storage.Create(path);
  if (!file) return Fail(file);
  std::unique_ptr<AppendFile> target = std::move(*file);
  if (source.seal) target = std::make_unique<SealedFile>(std::move(target), *source.seal);
  McapWriter writer(std::move(target), McapCompression::kZstd);
  const McapPreamble preamble = source.survey.Preamble(source.recording.scan.header.program_version);
  RETURN_IF_ERROR(writer.WritePreamble(preamble));
  Copier copier(writer, preamble, source.survey.recording_id);
  const auto read = ReadMcap(source.bytes, source.name, copier);
  if (!read) return Fail(read);
  RETURN_IF_ERROR(copier.status());
  for (const McapMetadata& metadata : source.survey.others) RETURN_IF_ERROR(writer.WriteMetadata(metadata));
  if (source.survey.recovery) {
    RETURN_IF_ERROR(writer.WriteMetadata({std::string(kRecoveryRecordName), *source.survey.recovery}));
  } else if (!source.recording.report.clean()) {
    const std::string json = LossesJson(summary).dump();
    RETURN_IF_ERROR(
        writer.WriteMetadata({std::string(kRecoveryRecordName), {{kJsonKey, json}, {kSha256Key, Sha256OfText(json)}}}));
  }
  RETURN_IF_ERROR(writer.WriteMetadata({std::string(kEndRecordName), EndOf(source)}));
  RETURN_IF_ERROR(writer.Finish());
  return copier.Digest();
}

/// Reads the new file as anybody would, and compares.
Status Verify(Storage& storage, const std::string& path, const Source& source, const KeySource* keys,
              const std::string& digest) {
  const auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  std::vector<std::byte> plain = *bytes;
  if (source.seal) {
    auto unsealed = UnsealRecording(plain, path, keys);
    if (!unsealed) return Fail(unsealed);
    plain = std::move(unsealed->bytes);
  }
  const auto again = ParseRecording(plain, path);
  if (!again) return Fail(again);
  MessageDigest read;
  const auto report = ReadMcap(plain, path, read);
  if (!report) return Fail(report);
  if (report->clean() && read.Hex() == digest && ScanHash(again->scan) == ScanHash(source.recording.scan)) return {};
  return Fail("recover " + source.name, "what was written reads back differently", "check the disk and memory");
}

Result<RecoverySummary> RecoverSource(Storage& storage, const Source& source, const std::string& out,
                                      const KeySource* keys) {
  RecoverySummary summary = Summarise(source);
  // Not the temporary name of a recording: that may be the very one which is recovered, as process ids repeat.
  const std::string temporary = TemporaryName(out + std::string(kCopyMark));
  if (storage.Exists(temporary)) RETURN_IF_ERROR(storage.Remove(temporary));
  const auto write = [&]() -> Status {
    const auto digest = WriteCopy(storage, temporary, source, summary);
    if (!digest) return Fail(digest);
    RETURN_IF_ERROR(Verify(storage, temporary, source, keys, *digest));
    return storage.Rename(temporary, out);
  };
  Status status = write();
  if (status) return summary;
  if (storage.Exists(temporary)) (void)storage.Remove(temporary);
  return Fail(status);
}

/// Copies that a recovery had begun when its program died; what they are copies of is still there.
Status RemoveBegunCopies(Storage& storage, const std::string& prefix, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name.find(std::string(kCopyMark) + ".part-") == std::string::npos || storage.InUse(prefix + name)) continue;
    RETURN_IF_ERROR(storage.Remove(prefix + name));
  }
  return {};
}

/// NAME and PID of "NAME.part-PID"; nothing if a name is not of that kind.
std::optional<std::pair<std::string, std::string>> SplitPartName(const std::string& name) {
  constexpr std::string_view kMark = ".part-";
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string::npos || mark == 0) return std::nullopt;
  const std::string pid = name.substr(mark + kMark.size());
  if (pid.empty() || pid.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return std::pair(name.substr(0, mark), pid);
}

/// `path` if it is free, else one like it that is.
std::string FreeName(const Storage& storage, const std::string& path) {
  if (!storage.Exists(path)) return path;
  const std::size_t slash = path.rfind('/');
  std::size_t dot = path.find('.', slash == std::string::npos ? 0 : slash + 1);
  if (dot == std::string::npos) dot = path.size();
  for (int number = 1;; ++number) {
    const std::string name = path.substr(0, dot) + ".recovered-" + std::to_string(number) + path.substr(dot);
    if (!storage.Exists(name)) return name;
  }
}

bool KeyIsMissing(std::span<const std::byte> bytes, const std::string& path, const KeySource* keys) {
  if (!LooksSealed(bytes)) return false;
  const auto id = SealedKeyId(bytes, path);
  return id && (keys == nullptr || !keys->Key(*id));
}

}  // namespace

std::string RecoverySummary::BriefReport() const {
  std::string text = std::to_string(levels) + " levels saved";
  for (const auto& [topic, count] : messages_lost) text += ", " + std::to_string(count) + " of " + topic + " lost";
  if (chunks_lost > 0) text += ", " + std::to_string(chunks_lost) + " chunks damaged";
  if (frames_lost > 0) text += ", " + std::to_string(frames_lost) + " sealed frames lost";
  if (skipped_bytes > 0) text += ", " + std::to_string(skipped_bytes) + " bytes of torn writes left out";
  if (unprotected > 0) text += ", " + std::to_string(unprotected) + " records without a CRC left out";
  if (!was_finished) text += "; the recording had not been finished";
  return text + (lossless ? "; nothing is known to be missing" : "");
}

Result<RecoverySummary> RecoverRecording(Storage& storage, const std::string& path, const std::string& out,
                                         const KeySource* keys, RecoveredAs as) {
  if (storage.Resolve(path) == storage.Resolve(out)) {
    return Fail("recover " + path, "the new file has the name of the old one", "choose another name for --out");
  }
  auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  auto source = OpenSource(std::move(*bytes), path, keys);
  if (!source) return Fail(source);
  if (as == RecoveredAs::kPlain) source->seal.reset();
  return RecoverSource(storage, *source, out, keys);
}

Result<std::vector<OpenRecording>> RecoverOpenRecordings(Storage& storage, const std::string& folder,
                                                         const KeySource* keys) {
  const auto names = storage.List(folder);
  if (!names) return Fail(names);
  const std::string prefix = folder.empty() || folder == "." ? "" : folder + "/";
  std::vector<OpenRecording> found;
  RETURN_IF_ERROR(RemoveBegunCopies(storage, prefix, *names));
  for (const std::string& name : *names) {
    const auto split = SplitPartName(name);
    const std::string part = prefix + name;
    if (!split || !storage.Exists(part) || storage.InUse(part)) continue;
    auto bytes = storage.ReadAll(part, kMaxInputBytes);
    if (!bytes) {
      found.push_back({part, "", part, Fail(bytes)});
      continue;
    }
    if (!LooksLikeRecording(*bytes)) continue;
    const bool later = KeyIsMissing(*bytes, part, keys);
    const std::string base = prefix + split->first;
    const std::string out = FreeName(storage, base);
    const auto source = OpenSource(std::move(*bytes), part, keys);
    auto outcome = source ? RecoverSource(storage, *source, out, keys) : Result<RecoverySummary>(Fail(source));
    OpenRecording open{part, outcome ? out : "", part, std::move(outcome)};
    if (open.outcome && open.outcome->lossless) {
      if (storage.Remove(part)) open.kept.clear();
    } else if (!later) {
      const std::string kept = FreeName(storage, base + ".damaged-" + split->second);
      if (storage.Rename(part, kept)) open.kept = kept;
    }
    found.push_back(std::move(open));
  }
  return found;
}

}  // namespace annulus
