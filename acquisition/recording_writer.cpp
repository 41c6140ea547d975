#include <cmath>
#include <utility>

#include "acquisition/mcap_writer.h"
#include "acquisition/recording.h"
#include "acquisition/recording_names.h"
#include "acquisition/scan_hash.h"
#include "acquisition/scan_json.h"
#include "base/ensure.h"
#include "base/sha256.h"

namespace annulus {
namespace {

enum ChannelId : std::uint16_t { kLevels = 1, kAxis = 2, kEvents = 3 };

std::string Sha256OfText(const std::string& text) { return Sha256Hex(std::as_bytes(std::span(text))); }

/// The header twice, so that damage to one copy does not cost the scan; channels and schemas after it.
McapPreamble PreambleOf(const ScanHeader& header) {
  const std::string json = JsonFromHeader(header);
  const McapMetadata scan{std::string(kScanRecordName), {{kJsonKey, json}, {kSha256Key, Sha256OfText(json)}}};
  McapPreamble preamble;
  preamble.library = header.program_version.empty() ? "annulus" : "annulus " + header.program_version;
  preamble.metadata = {scan, scan};
  auto add = [&](ChannelId id, std::string_view topic, std::string_view schema_name, std::string_view schema) {
    preamble.schemas.push_back({id, std::string(schema_name), "jsonschema", std::string(schema)});
    preamble.channels.push_back({id, id, std::string(topic), "json", {}});
  };
  add(kLevels, kLevelsTopic, "annulus.Level", kLevelSchema);
  add(kAxis, kAxisTopic, "annulus.AxisPoint", kAxisSchema);
  add(kEvents, kEventsTopic, "annulus.Event", kEventSchema);
  return preamble;
}

}  // namespace

struct RecordingWriter::State {
  Storage* storage;
  std::string path;
  std::string temporary;
  McapWriter mcap;
  RecordingOptions options;
  ScanHasher hasher;
  std::size_t sensor_count;
  std::uint64_t levels = 0;
  std::uint32_t axis_points = 0;
  std::uint32_t events = 0;

  Status Append(ChannelId channel, std::uint32_t sequence, std::chrono::nanoseconds time, const std::string& json) {
    const auto time_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0));
    const McapMessage message{channel, sequence, time_ns, time_ns, json};
    return mcap.WriteChunk(std::span(&message, 1));
  }
};

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
  auto file = storage.Create(temporary);
  if (!file) return Fail(file);
  auto state = std::make_unique<State>(State{.storage = &storage,
                                             .path = path,
                                             .temporary = temporary,
                                             .mcap = McapWriter(std::move(*file), McapCompression::kZstd),
                                             .options = options,
                                             .hasher = ScanHasher(header),
                                             .sensor_count = header.calibration.sensors.size()});
  RecordingWriter writer(std::move(state));
  if (Status started = writer.Start(header); !started) {
    writer.Discard();
    started.error().attempted = "write " + path;
    return Fail(started);
  }
  return writer;
}

Status RecordingWriter::Start(const ScanHeader& header) {
  if (state_->options.reserve_bytes > 0) RETURN_IF_ERROR(state_->mcap.Reserve(state_->options.reserve_bytes));
  RETURN_IF_ERROR(state_->mcap.WritePreamble(PreambleOf(header)));
  return state_->mcap.Sync();
}

Status RecordingWriter::AppendLevel(const ScanLevel& level) {
  ENSURE(level.readings.size() == state_->sensor_count, "a level has one reading per sensor");
  for (const RangeReading& reading : level.readings) ENSURE(std::isfinite(reading.z_mm), "a reading has a height");
  const auto sequence = static_cast<std::uint32_t>(state_->levels);
  RETURN_IF_ERROR(state_->Append(kLevels, sequence, level.time, JsonFromLevel(level)));
  state_->hasher.Add(level);
  ++state_->levels;
  const std::uint32_t every = state_->options.sync_every_levels;
  if (every > 0 && state_->levels % every == 0) return state_->mcap.Sync();
  return {};
}

Status RecordingWriter::AppendEvent(std::chrono::nanoseconds time, const std::string& text) {
  RETURN_IF_ERROR(state_->Append(kEvents, state_->events, time, JsonFromEvent({time, text})));
  ++state_->events;
  return {};
}

Status RecordingWriter::AppendAxis(std::chrono::nanoseconds time, double z_mm) {
  ENSURE(std::isfinite(z_mm), "the carriage has a height");
  RETURN_IF_ERROR(state_->Append(kAxis, state_->axis_points, time, JsonFromAxisPoint({time, z_mm})));
  ++state_->axis_points;
  return {};
}

Status RecordingWriter::Finish() {
  const std::string levels = std::to_string(state_->levels);
  const std::string scan_hash = state_->hasher.Finish();
  const std::map<std::string, std::string> end{
      {kLevelCountKey, levels}, {kScanHashKey, scan_hash}, {kSha256Key, Sha256OfText(levels + scan_hash)}};
  RETURN_IF_ERROR(state_->mcap.WriteMetadata({std::string(kEndRecordName), end}));
  RETURN_IF_ERROR(state_->mcap.Finish());
  return state_->storage->Rename(state_->temporary, state_->path);
}

void RecordingWriter::Discard() {
  Storage& storage = *state_->storage;
  const std::string temporary = state_->temporary;
  state_.reset();  // closes the file
  if (storage.Exists(temporary)) (void)storage.Remove(temporary);
}

const std::string& RecordingWriter::temporary_path() const { return state_->temporary; }
std::uint64_t RecordingWriter::level_count() const { return state_->levels; }

Status WriteRecording(Storage& storage, const std::string& path, const Scan& scan) {
  auto writer = RecordingWriter::Create(storage, path, scan.header, {.reserve_bytes = 0, .sync_every_levels = 0});
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
