#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "acquisition/mcap_writer.h"
#include "acquisition/point_cloud.h"
#include "acquisition/recording.h"
#include "acquisition/recording_channels.h"
#include "acquisition/recording_names.h"
#include "acquisition/scan_hash.h"
#include "acquisition/scan_json.h"
#include "base/ensure.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Without a level, a chunk is written once it spans so much.
constexpr nanoseconds kLongestChunk = std::chrono::milliseconds(100);
constexpr std::size_t kLargestChunkBytes = std::size_t{64} << 10;

/// Most bytes that a recording takes, from measurements: noise in every digit of every number, raw bytes of USB.
constexpr std::uint64_t kHeaderBytes = 32'768;
constexpr std::uint64_t kHeaderBytesPerSensor = 512;
constexpr std::uint64_t kLevelBytes = 1'024;
constexpr std::uint64_t kLevelBytesPerSensor = 48;

/// Something that waits for its chunk.
struct Pending {
  RecordingChannel channel = RecordingChannel::kLevels;
  std::uint32_t sequence = 0;
  nanoseconds time{0};
  nanoseconds order{0};  ///< `time`, but never before that of the one before it in its stream.
  std::string data;
};

/// All raw records are one stream: a replay needs them in the order in which they passed.
std::size_t StreamOf(RecordingChannel channel) {
  return std::min(static_cast<std::size_t>(channel), static_cast<std::size_t>(RecordingChannel::kUsb));
}

std::uint64_t FileTime(nanoseconds time) { return static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0)); }

/// Ten seconds of what a scan makes.
std::size_t QueueBytes(const ScanHeader& header, const RecordingOptions& options) {
  if (options.queue_bytes > 0) return options.queue_bytes;
  constexpr double kSeconds = 10.0;
  constexpr double kMostLevels = 10'000.0;
  constexpr std::size_t kLeast = std::size_t{4} << 20;
  const double levels = std::clamp(kSeconds * header.machine.level_rate_hz, 0.0, kMostLevels);
  const std::uint64_t bytes = RecordingReserve(static_cast<std::uint32_t>(levels), header.calibration.sensors.size());
  return std::max<std::size_t>(bytes, kLeast);
}

/// The file under a new recording: sealed if there are keys.
Result<std::unique_ptr<AppendFile>> OpenFile(Storage& storage, const std::string& temporary, const KeySource* keys) {
  std::optional<Seal> seal;
  if (keys != nullptr) {
    const auto id = keys->NewRecordingKeyId();
    if (!id) return Fail(id);
    const auto key = keys->Key(*id);
    if (!key) return Fail(key);
    seal = Seal{*id, *key, RandomSealedFileId()};
  }
  auto file = storage.Create(temporary);
  if (!file) return Fail(file);
  if (!seal) return std::move(*file);
  return std::make_unique<SealedFile>(std::move(*file), std::move(*seal));
}

}  // namespace

std::uint64_t RecordingReserve(std::uint32_t levels, std::size_t sensors) {
  return kHeaderBytes + kHeaderBytesPerSensor * sensors + levels * (kLevelBytes + kLevelBytesPerSensor * sensors);
}

struct RecordingWriter::State {
  Storage* storage;
  std::string path;
  std::string temporary;
  DiskWriter* disk;  ///< The file of `mcap`, which owns it.
  McapWriter mcap;
  RingCalibration calibration;
  std::size_t reference_count;
  ScanHasher hasher;
  std::string recording_id{};
  std::uint64_t levels = 0;
  std::map<RecordingChannel, std::uint32_t> counts{};
  std::vector<Pending> pending{};
  std::size_t pending_bytes = 0;
  std::array<nanoseconds, kRecordingChannels.size() + 1> newest{};  ///< By stream.
  std::vector<std::uint64_t> level_blocks{};                        ///< Blocks of the file up to each level.
  std::optional<Error> failure{};                                   ///< The first; final.
  bool settling = false;                                            ///< Somebody waits for the disk.

  Status Latch(Status status) {
    if (!status && !failure) failure = status.error();
    return status;
  }
  [[nodiscard]] Status Check() const {
    if (failure) return tl::unexpected<Error>(*failure);
    return {};
  }
  void Collect(RecordingChannel channel, nanoseconds time, std::string data);
  Status Add(RecordingChannel channel, nanoseconds time, std::string data);
  Status Flush();
  Status Start(const ScanHeader& header, std::uint64_t reserve_bytes);
  Status End();
  [[nodiscard]] std::string MessageCounts() const;
};

void RecordingWriter::State::Collect(RecordingChannel channel, nanoseconds time, std::string data) {
  nanoseconds& newest_of_stream = newest[StreamOf(channel)];
  newest_of_stream = std::max(newest_of_stream, time);
  pending_bytes += data.size();
  pending.push_back({channel, counts[channel]++, time, newest_of_stream, std::move(data)});
}

Status RecordingWriter::State::Add(RecordingChannel channel, nanoseconds time, std::string data) {
  RETURN_IF_ERROR(Check());
  const bool due = !pending.empty() && time - pending.front().time > kLongestChunk;
  if (due || pending_bytes > kLargestChunkBytes) RETURN_IF_ERROR(Flush());
  Collect(channel, time, std::move(data));
  return {};
}

Status RecordingWriter::State::Flush() {
  if (pending.empty()) return Check();
  std::stable_sort(pending.begin(), pending.end(),
                   [](const Pending& a, const Pending& b) { return a.order < b.order; });
  std::vector<McapMessage> messages;
  messages.reserve(pending.size());
  for (const Pending& entry : pending) {
    const std::uint64_t time = FileTime(entry.time);
    messages.push_back({static_cast<std::uint16_t>(entry.channel), entry.sequence, time, time, entry.data});
  }
  RETURN_IF_ERROR(Latch(mcap.WriteChunk(messages)));
  const nanoseconds now = pending.back().order;
  pending.clear();
  pending_bytes = 0;
  return Latch(disk->Tick(now));
}

Status RecordingWriter::State::Start(const ScanHeader& header, std::uint64_t reserve_bytes) {
  if (reserve_bytes > 0) RETURN_IF_ERROR(mcap.Reserve(reserve_bytes));
  const std::string json = JsonFromHeader(header);
  recording_id = RecordingId(json);
  RETURN_IF_ERROR(mcap.WritePreamble(RecordingPreamble(json, header.program_version)));
  RETURN_IF_ERROR(mcap.Sync());
  return storage->SyncFolder(temporary);
}

std::string RecordingWriter::State::MessageCounts() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [channel, count] : counts) json[std::string(TopicOf(channel))] = count;
  return json.dump();
}

Status RecordingWriter::State::End() {
  RETURN_IF_ERROR(Flush());
  const std::string level_count = std::to_string(levels);
  const std::string scan_hash = hasher.Finish();
  const std::string messages = MessageCounts();
  const std::map<std::string, std::string> end{{kLevelCountKey, level_count},
                                               {kScanHashKey, scan_hash},
                                               {kMessageCountsKey, messages},
                                               {kRecordingKey, recording_id},
                                               {kSha256Key, Sha256OfText(level_count + scan_hash + messages)}};
  RETURN_IF_ERROR(mcap.WriteMetadata({std::string(kEndRecordName), end}));
  RETURN_IF_ERROR(mcap.Finish());
  return storage->Rename(temporary, path);
}

RecordingWriter::RecordingWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;
RecordingWriter::~RecordingWriter() = default;

Result<RecordingWriter> RecordingWriter::Create(Storage& storage, const std::string& path, const ScanHeader& header,
                                                const RecordingOptions& options) {
  if (const auto checked = CheckHeader(header); !checked) {
    return Fail("record a scan in " + path, "the scan's header is impossible: " + checked.error(),
                "check the configuration and the ring's calibration");
  }
  const std::string temporary = TemporaryName(path);
  auto file = OpenFile(storage, temporary, options.keys);
  if (!file) return Fail(file);
  DiskWriterOptions disk_options;
  disk_options.mode = options.disk;
  disk_options.sync_every = options.sync_every;
  disk_options.sync_every_blocks = options.sync_every_levels;
  disk_options.queue_bytes = QueueBytes(header, options);
  disk_options.now = options.disk_clock;
  auto disk = std::make_unique<DiskWriter>(std::move(*file), std::move(disk_options));
  DiskWriter* const borrowed = disk.get();
  auto state = std::make_unique<State>(State{.storage = &storage,
                                             .path = path,
                                             .temporary = temporary,
                                             .disk = borrowed,
                                             .mcap = McapWriter(std::move(disk), McapCompression::kZstd),
                                             .calibration = header.calibration,
                                             .reference_count = header.reference ? header.reference->sensors.size() : 0,
                                             .hasher = ScanHasher(header)});
  RecordingWriter writer(std::move(state));
  if (Status started = writer.state_->Start(header, options.reserve_bytes); !started) {
    writer.Discard();
    started.error().attempted = "write " + path;
    return Fail(started);
  }
  return writer;
}

Status RecordingWriter::AppendLevel(const ScanLevel& level) {
  ENSURE(level.readings.size() == state_->calibration.sensors.size(), "a level has one reading per sensor");
  for (const RangeReading& reading : level.readings) ENSURE(std::isfinite(reading.z_mm), "a reading has a height");
  ENSURE(level.reference.size() == state_->reference_count, "a level has one reading per reference sensor");
  RETURN_IF_ERROR(state_->Check());
  state_->Collect(RecordingChannel::kLevels, level.time, JsonFromLevel(level));
  state_->Collect(RecordingChannel::kPoints, level.time, PointCloudJson(state_->calibration, level));
  RETURN_IF_ERROR(state_->Flush());
  state_->hasher.Add(level);
  ++state_->levels;
  state_->level_blocks.push_back(state_->disk->state().appended);
  return {};
}

Status RecordingWriter::AppendEvent(nanoseconds time, const std::string& text) {
  return state_->Add(RecordingChannel::kEvents, time, JsonFromEvent({time, text}));
}

Status RecordingWriter::AppendAxis(nanoseconds time, double z_mm) {
  ENSURE(std::isfinite(z_mm), "the carriage has a height");
  return state_->Add(RecordingChannel::kAxis, time, JsonFromAxisPoint({time, z_mm}));
}

Status RecordingWriter::AppendRaw(RawRecord record) {
  return state_->Add(ChannelOf(record.channel), record.time,
                     std::string(reinterpret_cast<const char*>(record.bytes.data()), record.bytes.size()));
}

Status RecordingWriter::AppendSafety(const SafetyLines& lines) {
  return state_->Add(RecordingChannel::kSafety, lines.time, JsonFromSafetyLines(lines));
}

Result<bool> RecordingWriter::Settle() {
  // Once is enough: what comes while the disk is waited for goes there in its own time.
  if (!state_->settling) RETURN_IF_ERROR(state_->Flush());
  auto settled = state_->disk->Settle();
  if (!settled && !state_->failure) state_->failure = settled.error();
  state_->settling = settled && !*settled;
  return settled;
}

Status RecordingWriter::Finish() {
  RETURN_IF_ERROR(state_->Check());
  return state_->Latch(state_->End());
}

void RecordingWriter::Discard() {
  Storage& storage = *state_->storage;
  const std::string temporary = state_->temporary;
  state_.reset();  // closes the file
  if (storage.Exists(temporary)) (void)storage.Remove(temporary);
}

const std::string& RecordingWriter::temporary_path() const { return state_->temporary; }
std::uint64_t RecordingWriter::level_count() const { return state_->levels; }

namespace {

/// How many levels lie in the first `blocks` blocks.
std::uint64_t LevelsWithin(const std::vector<std::uint64_t>& level_blocks, std::uint64_t blocks) {
  return static_cast<std::uint64_t>(std::upper_bound(level_blocks.begin(), level_blocks.end(), blocks) -
                                    level_blocks.begin());
}

}  // namespace

std::uint64_t RecordingWriter::written_levels() const {
  return LevelsWithin(state_->level_blocks, state_->disk->state().written);
}
std::uint64_t RecordingWriter::durable_levels() const {
  return LevelsWithin(state_->level_blocks, state_->disk->state().synced);
}
DiskState RecordingWriter::disk_state() const { return state_->disk->state(); }
std::string RecordingWriter::disk_note() const { return state_->disk->Note(); }

Status WriteRecording(Storage& storage, const std::string& path, const Scan& scan) {
  RecordingOptions options;
  options.sync_every_levels = 0;
  auto writer = RecordingWriter::Create(storage, path, scan.header, options);
  if (!writer) return Fail(writer);
  auto write = [&]() -> Status {
    for (const ScanLevel& level : scan.levels) RETURN_IF_ERROR(writer->AppendLevel(level));
    return writer->Finish();
  };
  Status status = write();
  if (!status) {
    writer->Discard();
    status.error().attempted = "write " + path;
  }
  return status;
}

}  // namespace annulus
