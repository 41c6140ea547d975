#pragma once

#include <string_view>

namespace annulus {

/// Names inside a recording (docs/formats.md).
inline constexpr std::string_view kScanRecordName = "annulus.scan";  ///< Metadata: the header; written twice.
inline constexpr std::string_view kEndRecordName = "annulus.end";    ///< Metadata: count and hash of the levels.
inline constexpr const char* kJsonKey = "json";
inline constexpr const char* kSha256Key = "sha256";
inline constexpr const char* kLevelCountKey = "levels";
inline constexpr const char* kScanHashKey = "scan_hash";
inline constexpr std::string_view kLevelsTopic = "/ring/levels";
inline constexpr std::string_view kAxisTopic = "/axis/track";
inline constexpr std::string_view kEventsTopic = "/events";

}  // namespace annulus
