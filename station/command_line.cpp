#include "station/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <map>
#include <string_view>

#include "base/ensure.h"
#include "station/commands.h"

namespace annulus {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kInterrupted = 130;

/// Commands of the design that a later version brings.
struct LaterCommand {
  const char* name;
  const char* purpose;
};
constexpr std::array<LaterCommand, 3> kLater{{{"convert", "other file formats"},
                                              {"batch", "many scans at once"},
                                              {"support-bundle", "collect what support needs"}}};

int PrintError(const Error& error, int code) {
  const std::string line = "annulus: " + error.Text() + "\n";
  std::fputs(line.c_str(), stderr);
  return code;
}

/// The innermost command that was given, and its whole name: "glasses fit".
struct GivenCommand {
  const CLI::App* app;
  std::string name;
};
GivenCommand Innermost(const CLI::App& app) {
  GivenCommand given{&app, ""};
  while (!given.app->get_subcommands().empty()) {
    given.app = given.app->get_subcommands().front();
    given.name += (given.name.empty() ? "" : " ") + given.app->get_name();
  }
  return given;
}

void AddProgressOption(CLI::App& app, ProgressMode& mode) {
  static const std::map<std::string, ProgressMode> kModes{
      {"auto", ProgressMode::kAuto}, {"json", ProgressMode::kJson}, {"none", ProgressMode::kNone}};
  app.add_option("--progress", mode, "progress on stderr: auto (terminals only), json (one object per line), none")
      ->transform(CLI::CheckedTransformer(kModes, CLI::ignore_case).description(""))
      ->type_name("auto|json|none");
}

int Run(const CommandWork& chosen, CommandIo& io) {
  ENSURE(chosen, "every command has its work");
  const Status status = chosen(io);
  if (io.stop().stop_requested() && !status) return PrintError(status.error(), kInterrupted);
  return status ? 0 : PrintError(status.error(), io.failure_code());
}

}  // namespace

const char* ProgramVersion() { return ANNULUS_VERSION; }

Status NotYet(CommandIo& io, const std::string& what) {
  io.set_failure_code(kWrongUsage);
  return Fail(what, "not yet in version " + std::string(ProgramVersion()), "see 'annulus --help' for what there is");
}

void AddLaterCommand(CLI::App& parent, const std::string& name, const std::string& purpose, CommandWork& chosen) {
  CLI::App* command = parent.add_subcommand(name, purpose + " (not yet)");
  command->allow_extras();
  command->fallthrough(false);  // whatever is given with it belongs to it
  command->callback([&chosen, name] { chosen = [name](CommandIo& io) { return NotYet(io, "run '" + name + "'"); }; });
}

void AddJsonOption(CLI::App& command, std::string& target) {
  command.add_option("--json", target, "write the result as JSON to FILE; - is standard output")->type_name("FILE");
}

void AddKeyFileOption(CLI::App& command, std::string& path) {
  command.add_option("--key-file", path, "keys of sealed recordings: lines ID = 64 hex digits, mode 0600")
      ->type_name("FILE");
}

int RunCommandLine(int argc, const char* const* argv, const std::stop_token& stop) {
  CLI::App app("annulus: scans people with a ring of range sensors, measures them and makes their glasses", "annulus");
  app.set_version_flag("--version", std::string("annulus ") + ProgramVersion());
  app.require_subcommand(1);
  app.fallthrough();
  app.footer("Example: annulus demo --out annulus-demo");
  ProgressMode progress = ProgressMode::kAuto;
  AddProgressOption(app, progress);
  CommandWork chosen;
  for (const auto& add :
       {AddDemoCommand,    AddScanCommand,      AddReplayCommand,   AddImportCommand,    AddExportCommand,
        AddInspectCommand, AddRecoverCommand,   AddFitCommand,      AddEvalCommand,      AddSectionCommand,
        AddSlabCommand,    AddRegionCommand,    AddDistanceCommand, AddLandmarksCommand, AddMeasureCommand,
        AddCompareCommand, AddGlassesCommand,   AddRenderCommand,   AddDoctorCommand,    AddSimDevicesCommand,
        AddBoothdCommand,  AddCalibrateCommand, AddBreathCommand,   AddDriftCommand,     AddCheckCommand,
        AddStoreCommand,   AddRebuildCommand,   AddServeCommand,    AddClayCommand,      AddFlattenCommand,
        AddElasticCommand, AddWrinklyCommand}) {
    add(app, chosen);
  }
  for (const LaterCommand& later : kLater) AddLaterCommand(app, later.name, later.purpose, chosen);

  PosixStorage storage;
  CommandIo io(storage, stop);
  try {
    app.parse(argc, argv);
    io.set_progress_mode(progress);
    return Run(chosen, io);
  } catch (const CLI::Success& success) {
    return app.exit(success);  // --help, --version
  } catch (const CLI::ParseError& error) {
    const GivenCommand given = Innermost(app);
    const CLI::App* command = given.app;
    const std::string attempted =
        command == &app ? "read the command line" : "read the options of '" + given.name + "'";
    const std::string help = command == &app ? "annulus --help" : "annulus " + given.name + " --help";
    std::string seen = error.what();
    const std::vector<std::string> unknown = app.remaining();
    if (command == &app && !unknown.empty()) {
      seen = "'" + unknown.front() + "' is not " + (unknown.front()[0] == '-' ? "an option" : "a command");
    }
    return PrintError({attempted, seen, "see '" + help + "'"}, kWrongUsage);
  } catch (const LogicError& error) {
    return PrintError({"run the command", error.what(), "please report this with the command that you gave"}, kFailed);
  } catch (const std::bad_alloc&) {
    return PrintError({"run the command", "out of memory", "give a smaller input or use a larger machine"}, kFailed);
  }
}

}  // namespace annulus
