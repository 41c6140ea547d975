#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "modeling/wrinkly/wrinkly_surface.h"
#include "station/command_io.h"
#include "station/commands.h"
#include "station/wrinkly_source.h"

namespace annulus {

/// Adds one part of the command `wrinkly`.
void AddWrinklyShuffle(CLI::App& wrinkly, CommandWork& chosen);
void AddWrinklyMesh(CLI::App& wrinkly, CommandWork& chosen);
void AddWrinklyRender(CLI::App& wrinkly, CommandWork& chosen);
void AddWrinklyFit(CLI::App& wrinkly, CommandWork& chosen);

/// The surface as it is typed.
struct WrinklySurfaceOptions {
  WrinklyOptions surface;
  bool rounded = false;
  bool four = false;

  [[nodiscard]] WrinklyOptions Chosen() const;
};
void AddSurfaceOptions(CLI::App& command, WrinklySurfaceOptions& options);

}  // namespace annulus
