#include "firmware_iface/axis_reading.h"

namespace annulus {

AxisReadingLayout ReadingLayout(const AxisRegisterMap& map) {
  return {map.position, map.drive_time, map.word_order, map.units_per_mm};
}

bool AxisReadingDecoder::Covers(const RegisterBlock& registers) const {
  return registers.HasLong(layout_.position) &&
         (layout_.drive_time == kNoRegister || registers.HasLong(layout_.drive_time));
}

AxisReading AxisReadingDecoder::Decode(const RegisterBlock& registers) {
  AxisReading reading;
  reading.z = Millimetres(registers.Signed(layout_.position) / layout_.units_per_mm);
  if (layout_.drive_time == kNoRegister) return reading;
  // What counts is the difference to the last reading.
  drive_time_us_ += static_cast<std::uint32_t>(registers.Long(layout_.drive_time) -
                                               static_cast<std::uint32_t>(drive_time_us_ & 0xFFFFFFFFU));
  reading.drive_time = std::chrono::microseconds(static_cast<std::int64_t>(drive_time_us_));
  return reading;
}

}  // namespace annulus
