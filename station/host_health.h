#pragma once

#include <string>
#include <vector>

#include "acquisition/scanner.h"

namespace annulus {

/// What the computer's own sensors say against a scan: checks "temperature" and "supply". An alarm is a file of the
/// kernel that reads 1 (hwmon: temp…_crit_alarm, temp…_alarm, in…_lcrit_alarm, in…_min_alarm), or a thermal zone at or
/// beyond its critical trip point. A computer without such sensors passes. `sysfs`: where the kernel shows them.
[[nodiscard]] std::vector<ArmCheck> CheckHostHealth(const std::string& sysfs = "/sys");

}  // namespace annulus
