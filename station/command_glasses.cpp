// glasses: design a frame, put it on a head, hand it over.

#include "station/command_glasses.h"

#include <CLI/CLI.hpp>

namespace annulus {

void AddGlassesCommand(CLI::App& app, CommandWork& chosen) {
  CLI::App* command = app.add_subcommand("glasses", "design a frame, put it on a head, export it");
  command->require_subcommand(1);
  command->footer("Example: annulus glasses design --style boston --out frame.json");
  AddGlassesDesign(*command, chosen);
  AddGlassesFit(*command, chosen);
  AddGlassesRank(*command, chosen);
  AddGlassesExport(*command, chosen);
}

}  // namespace annulus
