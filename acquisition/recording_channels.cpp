#include "acquisition/recording_channels.h"

#include "acquisition/point_cloud.h"
#include "acquisition/recording_names.h"
#include "acquisition/scan_json.h"
#include "base/ensure.h"
#include "base/sha256.h"

namespace annulus {
namespace {

/// How the messages of a channel are described. Raw bytes have no schema.
struct ChannelKind {
  RecordingChannel id;
  std::string_view topic;
  std::string_view schema_name;
  std::string_view schema;
};

std::array<ChannelKind, kRecordingChannels.size()> Kinds() {
  using enum RecordingChannel;
  return {{{kLevels, kLevelsTopic, "annulus.Level", kLevelSchema},
           {kAxis, kAxisTopic, "annulus.AxisPoint", kAxisSchema},
           {kEvents, kEventsTopic, "annulus.Event", kEventSchema},
           {kSafety, kSafetyTopic, "annulus.SafetyLines", kSafetySchema},
           {kPoints, kPointsTopic, kPointCloudName, kPointCloudSchema},
           {kUsb, kUsbTopic, "", ""},
           {kCan, kCanTopic, "", ""},
           {kModbus, kModbusTopic, "", ""},
           {kCalls, kCallsTopic, "", ""}}};
}

}  // namespace

std::string_view TopicOf(RecordingChannel channel) {
  for (const ChannelKind& kind : Kinds()) {
    if (kind.id == channel) return kind.topic;
  }
  ENSURE(false, "every channel has a topic");
  return {};
}

RecordingChannel ChannelOf(RawChannel channel) {
  switch (channel) {
    case RawChannel::kUsb:
      return RecordingChannel::kUsb;
    case RawChannel::kCan:
      return RecordingChannel::kCan;
    case RawChannel::kModbus:
      return RecordingChannel::kModbus;
    case RawChannel::kCall:
      return RecordingChannel::kCalls;
  }
  ENSURE(false, "every seam has a channel");
  return RecordingChannel::kCalls;
}

McapPreamble RecordingPreamble(const std::string& header_json, const std::string& program_version) {
  const McapMetadata scan{std::string(kScanRecordName),
                          {{kJsonKey, header_json}, {kSha256Key, Sha256OfText(header_json)}}};
  McapPreamble preamble;
  preamble.library = program_version.empty() ? "annulus" : "annulus " + program_version;
  preamble.metadata = {scan, scan};
  for (const ChannelKind& kind : Kinds()) {
    const auto id = static_cast<std::uint16_t>(kind.id);
    const bool described = !kind.schema_name.empty();
    if (described) {
      preamble.schemas.push_back({id, std::string(kind.schema_name), "jsonschema", std::string(kind.schema)});
    }
    preamble.channels.push_back({id,
                                 described ? id : std::uint16_t{0},
                                 std::string(kind.topic),
                                 std::string(described ? std::string_view("json") : kBusEncoding),
                                 {{kRecordingKey, RecordingId(header_json)}}});
  }
  return preamble;
}

std::string RecordingId(std::string_view header_json) {
  constexpr std::size_t kDigits = 16;
  return Sha256OfText(header_json).substr(0, kDigits);
}

bool IsOfRecording(const std::map<std::string, std::string>& metadata, const std::string& recording_id) {
  const auto named = metadata.find(kRecordingKey);
  return named == metadata.end() || named->second == recording_id;
}

std::string Sha256OfText(std::string_view text) {
  return Sha256Hex(std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace annulus
