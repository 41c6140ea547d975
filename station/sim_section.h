#pragma once

#include "station/config.h"
#include "station/toml_table.h"

namespace annulus {

/// Reads the section of the configuration that says who and what is simulated. Throws toml_table::BadConfig.
void ReadSimSection(const toml::node& node, SimConfig& sim);

}  // namespace annulus
