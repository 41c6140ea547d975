#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>

#include "base/result.h"
#include "station/command_io.h"

namespace annulus {

/// The work of the command that was chosen on the command line.
using CommandWork = std::function<Status(CommandIo&)>;

/// Adds one command to the program: its options and help, and what to store in `chosen` when it is given.
/// `chosen` must outlive `app`.
void AddDemoCommand(CLI::App& app, CommandWork& chosen);
void AddScanCommand(CLI::App& app, CommandWork& chosen);
void AddReplayCommand(CLI::App& app, CommandWork& chosen);
void AddImportCommand(CLI::App& app, CommandWork& chosen);
void AddExportCommand(CLI::App& app, CommandWork& chosen);
void AddInspectCommand(CLI::App& app, CommandWork& chosen);
void AddRecoverCommand(CLI::App& app, CommandWork& chosen);
void AddFitCommand(CLI::App& app, CommandWork& chosen);
void AddEvalCommand(CLI::App& app, CommandWork& chosen);
void AddBreathCommand(CLI::App& app, CommandWork& chosen);
void AddSectionCommand(CLI::App& app, CommandWork& chosen);
void AddSlabCommand(CLI::App& app, CommandWork& chosen);
void AddClayCommand(CLI::App& app, CommandWork& chosen);
void AddFlattenCommand(CLI::App& app, CommandWork& chosen);
void AddElasticCommand(CLI::App& app, CommandWork& chosen);
void AddWrinklyCommand(CLI::App& app, CommandWork& chosen);
void AddRegionCommand(CLI::App& app, CommandWork& chosen);
void AddDistanceCommand(CLI::App& app, CommandWork& chosen);
void AddLandmarksCommand(CLI::App& app, CommandWork& chosen);
void AddMeasureCommand(CLI::App& app, CommandWork& chosen);
void AddCompareCommand(CLI::App& app, CommandWork& chosen);
void AddGlassesCommand(CLI::App& app, CommandWork& chosen);
void AddRenderCommand(CLI::App& app, CommandWork& chosen);
void AddDriftCommand(CLI::App& app, CommandWork& chosen);
void AddCheckCommand(CLI::App& app, CommandWork& chosen);
void AddDoctorCommand(CLI::App& app, CommandWork& chosen);
void AddSimDevicesCommand(CLI::App& app, CommandWork& chosen);
void AddBoothdCommand(CLI::App& app, CommandWork& chosen);
void AddServeCommand(CLI::App& app, CommandWork& chosen);
void AddCalibrateCommand(CLI::App& app, CommandWork& chosen);
void AddStoreCommand(CLI::App& app, CommandWork& chosen);
void AddRebuildCommand(CLI::App& app, CommandWork& chosen);

/// Adds a command of the design that a later version brings; it says so and exits 2.
void AddLaterCommand(CLI::App& parent, const std::string& name, const std::string& purpose, CommandWork& chosen);

/// The error of something that a later version brings; sets exit code 2.
[[nodiscard]] Status NotYet(CommandIo& io, const std::string& what);

/// Adds the option --json FILE ("-" = stdout) to a command that has a machine-readable result.
void AddJsonOption(CLI::App& command, std::string& target);

/// Adds the option --key-file FILE to a command that reads recordings.
void AddKeyFileOption(CLI::App& command, std::string& path);

}  // namespace annulus
