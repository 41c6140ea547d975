#include "acquisition/arm_check.h"

#include <algorithm>
#include <array>

namespace annulus {

const char* ArmCheckName(ArmCheckCode code) {
  static constexpr std::array<const char*, kArmCheckCodes> kNames{
      "watchdog_relay", "chain",    "homed", "alarms",      "buttons",   "brake",      "drive",
      "customer",       "consent",  "store", "calibration", "reference", "wall_clock", "temperature",
      "supply",         "priority", "ring",  "plan",        "disk"};
  return kNames.at(static_cast<std::size_t>(code));
}

bool ArmReport::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const ArmCheck& check) { return check.result.has_value(); });
}

}  // namespace annulus
