#pragma once

#include <string>
#include <string_view>

#include "acquisition/scan.h"

namespace annulus {

/// The calibrated points of a level as a message "foxglove.PointCloud" (JSON, data in base64), which common viewers
/// show: per return x, y, z in metres (station frame) and its quality (0 … 255) as intensity, all little-endian
/// float32.
[[nodiscard]] std::string PointCloudJson(const RingCalibration& calibration, const ScanLevel& level);

/// The name of the message's kind, and its schema in JSON Schema.
inline constexpr std::string_view kPointCloudName = "foxglove.PointCloud";
extern const std::string_view kPointCloudSchema;

}  // namespace annulus
