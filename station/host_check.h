#pragma once

#include <string>
#include <vector>

#include "station/config.h"
#include "station/doctor.h"

namespace annulus {

/// What of the computer matters to the devices: kernel, real-time priority, memory for USB transfers, free descriptors.
/// Real devices make a problem of what is only said for simulated ones.
std::vector<DoctorItem> CheckHost(const Config& config);

/// True if the path names anything.
[[nodiscard]] bool PathExists(const std::string& path);

}  // namespace annulus
