#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "base/units.h"
#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/register_block.h"

namespace annulus {

/// Where a reading of the axis lies in the registers.
struct AxisReadingLayout {
  std::uint16_t position = 0;
  std::uint16_t drive_time = kNoRegister;  ///< kNoRegister: the drive tells none.
  WordOrder word_order = WordOrder::kHighFirst;
  double units_per_mm = 1000.0;
};
[[nodiscard]] AxisReadingLayout ReadingLayout(const AxisRegisterMap& map);

/// Height and time of one reading.
struct AxisReading {
  Millimetres z{0.0};
  std::optional<std::chrono::nanoseconds> drive_time;  ///< Since the drive's clock was 0; nothing if it tells none.
};

/// Turns the registers of readings, in their order, into heights and times. The drive's 32-bit microseconds wrap every
/// 71.6 min: readings must not be further apart than that.
class AxisReadingDecoder {
 public:
  explicit AxisReadingDecoder(const AxisReadingLayout& layout) : layout_(layout) {}

  /// Whether a block has the registers that Decode needs.
  [[nodiscard]] bool Covers(const RegisterBlock& registers) const;
  /// Requires Covers.
  AxisReading Decode(const RegisterBlock& registers);

 private:
  AxisReadingLayout layout_;
  std::uint64_t drive_time_us_ = 0;  ///< Unwrapped.
};

}  // namespace annulus
