#pragma once

#include <string>
#include <string_view>

#include "acquisition/recording.h"
#include "acquisition/scan.h"
#include "base/result.h"

namespace annulus {

/// The JSON texts inside recordings and exported tables (docs/formats.md). Numbers keep every bit of a double, keys
/// carry units, a missing return is null. The failure of a reading function says in a few words what is wrong.

/// Every field of a header; bytes that are no UTF-8 are replaced.
[[nodiscard]] std::string JsonFromHeader(const ScanHeader& header);
tl::expected<ScanHeader, std::string> HeaderFromJson(std::string_view json);
/// What makes a header impossible (a number that is not finite, a radius that is not positive, no sensor …).
tl::expected<void, std::string> CheckHeader(const ScanHeader& header);

[[nodiscard]] std::string JsonFromLevel(const ScanLevel& level);
/// A level with exactly `sensor_count` readings, and `reference_count` of reference sensors.
tl::expected<ScanLevel, std::string> LevelFromJson(std::string_view json, std::size_t sensor_count,
                                                   std::size_t reference_count = 0);

[[nodiscard]] std::string JsonFromAxisPoint(const AxisPoint& point);
tl::expected<AxisPoint, std::string> AxisPointFromJson(std::string_view json);

[[nodiscard]] std::string JsonFromEvent(const RecordedEvent& event);
tl::expected<RecordedEvent, std::string> EventFromJson(std::string_view json);

[[nodiscard]] std::string JsonFromSafetyLines(const SafetyLines& lines);
tl::expected<SafetyLines, std::string> SafetyLinesFromJson(std::string_view json);

/// Schemas in JSON Schema of the messages.
extern const std::string_view kLevelSchema;
extern const std::string_view kAxisSchema;
extern const std::string_view kEventSchema;
extern const std::string_view kSafetySchema;

}  // namespace annulus
