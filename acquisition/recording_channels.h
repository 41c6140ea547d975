#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "acquisition/mcap_writer.h"
#include "acquisition/scan_sink.h"

namespace annulus {

/// The channels of a recording; the number is the channel's id in the file.
enum class RecordingChannel : std::uint16_t {
  kLevels = 1,
  kAxis = 2,
  kEvents = 3,
  kSafety = 4,
  kPoints = 5,
  kUsb = 6,
  kCan = 7,
  kModbus = 8,
  kCalls = 9,
};
inline constexpr std::array kRecordingChannels{
    RecordingChannel::kLevels, RecordingChannel::kAxis,   RecordingChannel::kEvents,
    RecordingChannel::kSafety, RecordingChannel::kPoints, RecordingChannel::kUsb,
    RecordingChannel::kCan,    RecordingChannel::kModbus, RecordingChannel::kCalls};

[[nodiscard]] std::string_view TopicOf(RecordingChannel channel);
[[nodiscard]] RecordingChannel ChannelOf(RawChannel channel);

/// The start of every recording: `header_json` twice, so that damage to one copy does not cost the scan; channels and
/// schemas after it.
[[nodiscard]] McapPreamble RecordingPreamble(const std::string& header_json, const std::string& program_version);

/// What every channel and the end record of a recording say (under kRecordingKey), so that its data are told from those
/// of another recording that the disk may hold in the same place: from its header, the same for the same header.
[[nodiscard]] std::string RecordingId(std::string_view header_json);

/// False if the metadata of a channel or of an end record name another recording. Older files name none: true.
[[nodiscard]] bool IsOfRecording(const std::map<std::string, std::string>& metadata, const std::string& recording_id);

/// Lower-case hex of SHA-256 of a text.
[[nodiscard]] std::string Sha256OfText(std::string_view text);

}  // namespace annulus
