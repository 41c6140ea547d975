#include "acquisition/scan_warning.h"

#include <array>

namespace annulus {

const char* WarningName(WarningCode code) {
  static constexpr std::array<const char*, kWarningCodes> kNames{
      "other",       "ticks_late",      "wall_clock_set",   "not_acknowledged",
      "disk_slow",   "reference_lost",  "ring_temperature", "memory_unlocked",
      "no_priority", "recording_saved", "recording_lost"};
  return kNames.at(static_cast<std::size_t>(code));
}

}  // namespace annulus
