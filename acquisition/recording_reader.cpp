#include <cstdlib>
#include <optional>
#include <utility>

#include "acquisition/mcap_reader.h"
#include "acquisition/recording.h"
#include "acquisition/recording_names.h"
#include "acquisition/scan_hash.h"
#include "acquisition/scan_json.h"
#include "base/log.h"
#include "base/sha256.h"

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
};

/// Puts a recording together from the records of its file.
class RecordingCollector final : public McapListener {
 public:
  void OnMetadata(const McapMetadata& metadata) override {
    if (metadata.name == kScanRecordName) TakeHeader(metadata);
    if (metadata.name == kEndRecordName) TakeEnd(metadata);
  }

  void OnMessage(const McapChannel& channel, const McapMessage& message) override {
    if (!has_header_) return;
    if (channel.topic == kLevelsTopic) TakeLevel(message);
    if (channel.topic == kAxisTopic) Take(AxisPointFromJson(message.data), recording_.axis, "an axis point");
    if (channel.topic == kEventsTopic) Take(EventFromJson(message.data), recording_.events, "an event");
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
    if (Sha256Hex(std::as_bytes(std::span(json))) != EntryOf(metadata, kSha256Key)) {
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
    has_header_ = true;
  }

  void TakeEnd(const McapMetadata& metadata) {
    const std::string levels = EntryOf(metadata, kLevelCountKey);
    const std::string hash = EntryOf(metadata, kScanHashKey);
    const std::string both = levels + hash;
    if (Sha256Hex(std::as_bytes(std::span(both))) != EntryOf(metadata, kSha256Key)) {
      return Note("the record of the scan's end is damaged");
    }
    end_ = ScanEnd{std::strtoull(levels.c_str(), nullptr, 10), hash};
  }

  void TakeLevel(const McapMessage& message) {
    if (message.sequence < next_sequence_) return Note("a level stands twice in the file");
    recording_.report.levels_lost += message.sequence - next_sequence_;
    next_sequence_ = std::uint64_t{message.sequence} + 1;
    auto level = LevelFromJson(message.data, recording_.scan.header.calibration.sensors.size());
    if (!level) {
      ++recording_.report.levels_lost;
      return Note("level " + std::to_string(message.sequence) + " cannot be read: " + level.error());
    }
    recording_.scan.levels.push_back(std::move(*level));
  }

  template <class Value>
  void Take(tl::expected<Value, std::string> value, std::vector<Value>& values, const std::string& what) {
    if (!value) return Note(what + " cannot be read: " + value.error());
    values.push_back(std::move(*value));
  }

  void CheckEnd();

  Recording recording_;
  bool has_header_ = false;
  int header_copies_ = 0;
  std::string header_problem_;
  std::uint64_t next_sequence_ = 0;
  std::optional<ScanEnd> end_;
};

/// Compares with what the writer said at the end.
void RecordingCollector::CheckEnd() {
  RecordingReport& report = recording_.report;
  if (!end_) {
    if (report.finished) Note("the record of the scan's end is missing");
    return;
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

Result<Recording> ParseRecording(std::span<const std::byte> bytes, const std::string& name) {
  RecordingCollector collector;
  const auto report = ReadMcap(bytes, name, collector);
  if (!report) return Fail(report);
  return collector.Finish(*report, name);
}

Result<Recording> ReadWholeRecording(Storage& storage, const std::string& path) {
  const auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  return ParseRecording(*bytes, path);
}

Result<Scan> ReadRecording(Storage& storage, const std::string& path) {
  auto recording = ReadWholeRecording(storage, path);
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
  return text.starts_with(kMcapMagic);
}

}  // namespace annulus
