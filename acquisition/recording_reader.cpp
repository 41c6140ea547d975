#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "acquisition/mcap_reader.h"
#include "acquisition/recording.h"
#include "acquisition/recording_channels.h"
#include "acquisition/recording_names.h"
#include "acquisition/scan_hash.h"
#include "acquisition/scan_json.h"
#include "base/log.h"

namespace annulus {
namespace {

std::string EntryOf(const McapMetadata& metadata, const char* key) {
  const auto found = metadata.entries.find(key);
  return found == metadata.entries.end() ? std::string() : found->second;
}

/// What the writer said at the end of a scan.
struct ScanEnd {
  std::uint64_t levels = 0;
  std::string scan_hash;
  std::map<std::string, std::uint64_t> messages;  ///< By topic; empty in older recordings.
};

/// The numbers of a JSON object; what is none is left out.
std::map<std::string, std::uint64_t> CountsFromJson(const std::string& text) {
  std::map<std::string, std::uint64_t> counts;
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return counts;
  for (const auto& [topic, count] : json.items()) {
    if (count.is_number_unsigned()) counts[topic] = count.get<std::uint64_t>();
  }
  return counts;
}

/// The raw channel of a topic; nothing if it is another one.
std::optional<RawChannel> RawChannelOf(std::string_view topic) {
  for (std::size_t i = 0; i < kRawChannels; ++i) {
    const auto channel = static_cast<RawChannel>(i);
    if (TopicOf(ChannelOf(channel)) == topic) return channel;
  }
  return std::nullopt;
}

/// Puts a recording together from the records of its file.
class RecordingCollector final : public McapListener {
 public:
  void OnMetadata(const McapMetadata& metadata) override {
    if (metadata.name == kScanRecordName) TakeHeader(metadata);
    if (metadata.name == kEndRecordName) TakeEnd(metadata);
    if (metadata.name == kRecoveryRecordName) recording_.report.recovered = true;
  }

  void OnMessage(const McapChannel& channel, const McapMessage& message) override {
    if (!has_header_) return;
    if (!IsOfRecording(channel.metadata, recording_id_)) return NoteForeignData();
    if (!IsNext(channel.topic, message.sequence))
      return Note("a message of " + channel.topic + " stands twice in the file");
    if (channel.topic == kLevelsTopic) return TakeLevel(message);
    if (channel.topic == kAxisTopic) return Take(AxisPointFromJson(message.data), recording_.axis, "an axis point");
    if (channel.topic == kEventsTopic) return Take(EventFromJson(message.data), recording_.events, "an event");
    if (channel.topic == kSafetyTopic)
      return Take(SafetyLinesFromJson(message.data), recording_.safety, "safety lines");
    if (const auto raw = RawChannelOf(channel.topic)) TakeRaw(*raw, message);
  }

  /// The recording once all records were told; `name` is what messages call it.
  Result<Recording> Finish(const McapReport& report, const std::string& name);

 private:
  void Note(std::string note) {
    if (recording_.report.notes.size() < McapReport::kMaxKept) recording_.report.notes.push_back(std::move(note));
  }

  void TakeHeader(const McapMetadata& metadata) {
    const std::string json = EntryOf(metadata, kJsonKey);
    ++header_copies_;
    if (Sha256OfText(json) != EntryOf(metadata, kSha256Key)) {
      header_problem_ = "its hash is wrong";
      return Note("a copy of the header is damaged");
    }
    if (has_header_) return;
    auto header = HeaderFromJson(json);
    if (!header) {
      header_problem_ = header.error();
      return;
    }
    recording_.scan.header = std::move(*header);
    recording_id_ = RecordingId(json);
    has_header_ = true;
  }

  void TakeEnd(const McapMetadata& metadata) {
    const std::string levels = EntryOf(metadata, kLevelCountKey);
    const std::string hash = EntryOf(metadata, kScanHashKey);
    const std::string messages = EntryOf(metadata, kMessageCountsKey);
    if (Sha256OfText(levels + hash + messages) != EntryOf(metadata, kSha256Key)) {
      return Note("the record of the scan's end is damaged");
    }
    if (!IsOfRecording(metadata.entries, recording_id_)) return NoteForeignData();
    end_ = ScanEnd{std::strtoull(levels.c_str(), nullptr, 10), hash, CountsFromJson(messages)};
  }

  void TakeLevel(const McapMessage& message) {
    recording_.report.levels_lost += message.sequence - next_sequence_;
    next_sequence_ = std::uint64_t{message.sequence} + 1;
    const ScanHeader& header = recording_.scan.header;
    auto level = LevelFromJson(message.data, header.calibration.sensors.size(),
                               header.reference ? header.reference->sensors.size() : 0);
    if (!level) {
      ++recording_.report.levels_lost;
      return Note("level " + std::to_string(message.sequence) + " cannot be read: " + level.error());
    }
    recording_.scan.levels.push_back(std::move(*level));
  }

  /// Notes how many messages of a topic there are, and how many are missing before this one; false if it was passed.
  bool IsNext(const std::string& topic, std::uint32_t sequence) {
    std::uint64_t& next = next_of_topic_[topic];
    if (sequence < next) return false;
    ++recording_.report.messages[topic];
    if (sequence > next) recording_.report.messages_lost[topic] += sequence - next;
    next = std::uint64_t{sequence} + 1;
    return true;
  }

  /// A sector that the disk kept from a deleted file, with a recording on it.
  void NoteForeignData() {
    if (!std::exchange(foreign_data_, true)) Note("data of another recording lie in the file; they were left out");
  }

  void TakeRaw(RawChannel channel, const McapMessage& message) {
    const auto bytes = std::as_bytes(std::span(message.data.data(), message.data.size()));
    const auto time = static_cast<std::int64_t>(message.log_time_ns);
    recording_.raw.push_back({channel, std::chrono::nanoseconds(time), {bytes.begin(), bytes.end()}});
  }

  template <class Value>
  void Take(tl::expected<Value, std::string> value, std::vector<Value>& values, const std::string& what) {
    if (!value) return Note(what + " cannot be read: " + value.error());
    values.push_back(std::move(*value));
  }

  void CheckEnd();

  Recording recording_;
  bool has_header_ = false;
  std::string recording_id_;
  bool foreign_data_ = false;
  int header_copies_ = 0;
  std::string header_problem_;
  std::uint64_t next_sequence_ = 0;
  std::map<std::string, std::uint64_t> next_of_topic_;
  std::optional<ScanEnd> end_;
};

/// Compares with what the writer said at the end.
void RecordingCollector::CheckEnd() {
  RecordingReport& report = recording_.report;
  if (!end_) {
    if (report.finished) Note("the record of the scan's end is missing");
    return;
  }
  for (const auto& [topic, count] : end_->messages) {
    const std::uint64_t next = next_of_topic_[topic];
    if (count > next) report.messages_lost[topic] += count - next;
  }
  if (end_->levels > next_sequence_) {
    Note("the scan ended after " + std::to_string(end_->levels) + " levels, the last one found is number " +
         std::to_string(next_sequence_));
    report.levels_lost += end_->levels - next_sequence_;
  } else if (report.levels_lost == 0 && ScanHash(recording_.scan) != end_->scan_hash) {
    Note("the hash of the scan differs from the one written at its end");
  }
}

Result<Recording> RecordingCollector::Finish(const McapReport& report, const std::string& name) {
  const std::string attempted = "read " + name;
  if (header_copies_ == 0) {
    return Fail(attempted, "it is an MCAP file without the record 'annulus.scan'",
                "give a recording that this program wrote");
  }
  if (!has_header_) {
    return Fail(attempted, "the header of the recording is unusable: " + header_problem_,
                "take another copy of the file, or a newer version of the program");
  }
  recording_.report.finished = report.finished;
  for (const McapDamage& damage : report.damages) {
    Note("at byte " + std::to_string(damage.offset) + ": " + damage.what);
  }
  if (report.unprotected > 0) Note(std::to_string(report.unprotected) + " records without a CRC were left out");
  CheckEnd();
  if (recording_.scan.levels.empty()) {
    return Fail(attempted, "it holds no readable level", "record or import the scan again");
  }
  return std::move(recording_);
}

}  // namespace

namespace {

Result<Recording> ParsePlain(std::span<const std::byte> bytes, const std::string& name) {
  RecordingCollector collector;
  const auto report = ReadMcap(bytes, name, collector);
  if (!report) return Fail(report);
  return collector.Finish(*report, name);
}

}  // namespace

Result<Recording> ParseRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys) {
  if (!LooksSealed(bytes)) return ParsePlain(bytes, name);
  const auto opened = UnsealRecording(bytes, name, keys);
  if (!opened) return Fail(opened);
  auto recording = ParsePlain(opened->bytes, name);
  if (!recording) return recording;
  RecordingReport& report = recording->report;
  report.sealed = true;
  report.frames_lost = opened->frames_lost;
  report.notes.insert(report.notes.begin(), opened->notes.begin(), opened->notes.end());
  return recording;
}

Result<Recording> ReadWholeRecording(Storage& storage, const std::string& path, const KeySource* keys) {
  const auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  return ParseRecording(*bytes, path, keys);
}

Result<Scan> ReadRecording(Storage& storage, const std::string& path, const KeySource* keys) {
  auto recording = ReadWholeRecording(storage, path, keys);
  if (!recording) return Fail(recording);
  const RecordingReport& report = recording->report;
  if (!report.clean()) {
    std::string text = path + " is damaged or unfinished: " + std::to_string(report.levels_lost) + " levels lost";
    if (!report.notes.empty()) text += "; " + report.notes.front();
    Log(LogLevel::kWarning, text);
  }
  return std::move(recording->scan);
}

bool LooksLikeRecording(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with(kMcapMagic) || LooksSealed(bytes);
}

}  // namespace annulus
