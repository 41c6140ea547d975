#pragma once

#include <string_view>

namespace annulus {

/// Names inside a recording (docs/formats.md).
inline constexpr std::string_view kScanRecordName = "annulus.scan";  ///< Metadata: the header; written twice.
inline constexpr std::string_view kEndRecordName = "annulus.end";    ///< Metadata: count and hash of the levels.
/// Metadata: what a recovery found; once, in a recovered file.
inline constexpr std::string_view kRecoveryRecordName = "annulus.recovery";
inline constexpr const char* kJsonKey = "json";
inline constexpr const char* kSha256Key = "sha256";
inline constexpr const char* kLevelCountKey = "levels";
inline constexpr const char* kScanHashKey = "scan_hash";
inline constexpr const char* kMessageCountsKey = "messages";  ///< Of the end: JSON, messages by topic.
inline constexpr const char* kRecordingKey = "recording";     ///< Of channels and the end: see RecordingId.
inline constexpr std::string_view kLevelsTopic = "/ring/levels";
inline constexpr std::string_view kAxisTopic = "/axis/track";
inline constexpr std::string_view kEventsTopic = "/events";
inline constexpr std::string_view kSafetyTopic = "/safety/lines";
inline constexpr std::string_view kPointsTopic = "/points";
inline constexpr std::string_view kUsbTopic = "/bus/usb";
inline constexpr std::string_view kCanTopic = "/bus/can";
inline constexpr std::string_view kModbusTopic = "/bus/modbus";
inline constexpr std::string_view kCallsTopic = "/bus/calls";
inline constexpr std::string_view kBusEncoding = "annulus.bus";  ///< As acquisition/bus_record.h; no schema.

}  // namespace annulus
