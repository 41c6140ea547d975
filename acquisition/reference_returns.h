#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "acquisition/scan.h"
#include "base/frames.h"

namespace annulus {

/// What one reference sensor saw of the person at one time.
struct ReferenceReturn {
  std::chrono::nanoseconds time{0};  ///< Host clock, as ScanLevel::time.
  std::size_t sensor = 0;            ///< Index in ScanHeader::reference.
  Ray ray;                           ///< Station frame.
  double range_mm = 0.0;             ///< mm from the ray's origin.
  std::uint8_t quality = 255;        ///< Return quality, 0 (none) … 255 (best).
};

/// All readings of the reference sensors that are of the person, in the order of the levels: missing ones are left out,
/// and so are those that end outside the ring's circle of sensors, where the ring itself stands in the way when it
/// passes. Empty without reference sensors.
[[nodiscard]] std::vector<ReferenceReturn> ReferenceReturns(const Scan& scan);

}  // namespace annulus
