#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan_plan.h"
#include "base/result.h"
#include "base/units.h"
#include "station/config.h"

namespace annulus {

/// Names that PlanOfProfile knows: the built-in profiles, then those of the configuration.
[[nodiscard]] std::vector<std::string> ProfileNames(const Config& config);

/// True if the profile needs to know where the subject's top is: its height must be entered or searched for.
[[nodiscard]] bool NeedsTop(const Config& config, const std::string& name);

/// What the profile asks for, not yet held against the machine. `subject_height`: entered or found; without it a
/// profile that needs it fails.
Result<ScanPlan> PlanOfProfile(const Config& config, const std::string& name,
                               std::optional<Millimetres> subject_height);

}  // namespace annulus
