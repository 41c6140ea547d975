#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace annulus {

/// What is looked at before a scan.
enum class ArmCheckCode : std::uint8_t {
  kWatchdogRelay,  ///< It drops.
  kChain,          ///< Closed and let free.
  kHomed,
  kAlarms,   ///< No cause is latched.
  kButtons,  ///< None is stuck.
  kBrake,    ///< Shut.
  kDrive,    ///< Set as it was.
  kCustomer,
  kConsent,
  kStore,
  kCalibration,
  kReference,  ///< The reference check is fresh and good.
  kWallClock,  ///< The computer's clock is set.
  kTemperature,
  kSupply,
  kPriority,  ///< The control thread may have real-time priority.
  kRing,
  kPlan,
  kDisk,
};
inline constexpr std::size_t kArmCheckCodes = static_cast<std::size_t>(ArmCheckCode::kDisk) + 1;
/// As on the wire: "watchdog_relay".
[[nodiscard]] const char* ArmCheckName(ArmCheckCode code);

/// One of the checks before a scan.
struct ArmCheck {
  std::string name;  ///< Of an ArmCheckCode; a newer program may have others.
  Status result;
};
struct ArmReport {
  std::vector<ArmCheck> checks;            ///< All of them, also after the first that failed.
  std::vector<std::string> plan_adjusted;  ///< Why the plan is not what was asked for.
  [[nodiscard]] bool passed() const;
};

}  // namespace annulus
