#pragma once

#include <string>
#include <vector>

#include "base/storage.h"
#include "station/config.h"

namespace annulus {

/// What was found of one thing.
enum class DoctorVerdict {
  kOk,
  kNone,     ///< Not there, and the configuration does not need it.
  kProblem,  ///< It must be there or be otherwise; `advice` says what to do.
};
[[nodiscard]] const char* DoctorVerdictText(DoctorVerdict verdict);

struct DoctorItem {
  std::string group;  ///< "host", "buses", "ring", "axis", "interlock".
  std::string name;   ///< "board 1004", "can0".
  DoctorVerdict verdict = DoctorVerdict::kOk;
  std::string seen;
  std::string advice;  ///< Empty unless kProblem.
};

struct DoctorReport {
  std::string config;  ///< What messages call the configuration.
  std::vector<DoctorItem> items;
  [[nodiscard]] bool healthy() const;
};

/// Whether the watchdog relay is made to pull in and to drop, which takes a second (TestWatchdogRelay). Enable stays
/// off.
enum class WatchdogTest { kSkip, kRun };

/// Looks at the host, at every bus that the system has, and at the devices that the configuration names. Nothing moves,
/// no emitter is switched on, and what is missing is an item and not a failure.
DoctorReport Diagnose(const Config& config, const std::string& config_name, Storage& storage,
                      WatchdogTest watchdog = WatchdogTest::kSkip);

}  // namespace annulus
