#pragma once

#include "station/commands.h"

namespace annulus {

/// Adds `glasses design`.
void AddGlassesDesign(CLI::App& parent, CommandWork& chosen);

/// Adds `glasses fit`.
void AddGlassesFit(CLI::App& parent, CommandWork& chosen);

/// Adds `glasses rank`.
void AddGlassesRank(CLI::App& parent, CommandWork& chosen);

/// Adds `glasses export`.
void AddGlassesExport(CLI::App& parent, CommandWork& chosen);

}  // namespace annulus
