#pragma once

#include "acquisition/scan_quality.h"
#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// The coverage of a scan, unrolled: theta to the right, height upwards; seen, doubtful, not seen. Fails if nothing at
/// all was seen.
[[nodiscard]] Result<RgbImage> DrawQuality(const ScanQuality& quality);

}  // namespace annulus
