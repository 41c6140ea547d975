#pragma once

#include "station/device_config.h"
#include "station/toml_table.h"

namespace annulus {

/// Read the sections of the configuration that say where the devices are. They throw toml_table::BadConfig.
void ReadRingSection(const toml::node& node, RingConfig& ring);
void ReadAxisSection(const toml::node& node, AxisConfig& axis);
void ReadInterlockSection(const toml::node& node, InterlockConfig& interlock);

}  // namespace annulus
