// boothd: the process that owns the devices, and a way to ask it by hand.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>

#include "acquisition/recording_recovery.h"
#include "base/log.h"
#include "station/booth_client.h"
#include "station/booth_server.h"
#include "station/booth_session.h"
#include "station/calibration_gate.h"
#include "station/command_line.h"
#include "station/commands.h"
#include "station/config.h"
#include "station/files.h"
#include "station/host_health.h"
#include "station/key_file.h"
#include "station/profile_plan.h"
#include "station/realtime.h"
#include "station/scanner_port.h"

namespace annulus {
namespace {

constexpr int kControlPriority = 80;
constexpr std::chrono::seconds kConnectPatience{3};
constexpr std::chrono::seconds kAskPatience{10};

struct BoothdCommand {
  std::string config = "sim";
  std::string socket = DefaultBoothSocket();
  std::string recordings = ".";
  std::string key_file;
  std::string ask;
};

BoothDescription Describe(const Config& config, const BoothSession& session) {
  BoothDescription booth;
  booth.station_id = config.station_id;
  booth.program_version = ProgramVersion();
  booth.simulated = AllSimulated(config);
  booth.ring_radius_mm = config.ring.radius_mm;
  for (const RingBoard& board : session.ring().boards()) {
    booth.boards.push_back({board.serial, board.first_sensor, board.sensor_count, board.firmware_version});
  }
  booth.axis = session.axis().identity().limits;
  booth.profiles = ProfileNames(config);
  return booth;
}

/// What of the system this process could not have; on real devices the priority is also a check before a scan.
std::vector<std::string> PrepareHost(const Config& config, ScannerOptions& scanner) {
  std::vector<std::string> notes;
  const auto note = [&](const Status& status) {
    if (!status) notes.push_back(status.error().Text());
  };
  note(LockMemory());
  const Status priority = MayTakePriority(kControlPriority);
  note(priority);
  if (!AllSimulated(config)) {
    scanner.host_checks = [priority] {
      std::vector<ArmCheck> checks = CheckHostHealth();
      checks.push_back({"real-time priority", priority});
      return checks;
    };
  }
  return notes;
}

/// The folder of the recordings, and those below it: a recording may be called day/scan.mcap.
std::vector<std::string> FoldersOf(const std::string& recordings) {
  namespace fs = std::filesystem;
  constexpr int kDeepest = 3;  // a folder that is shared with other things is not searched to its end
  std::vector<std::string> folders{recordings};
  std::error_code error;
  fs::recursive_directory_iterator entry(recordings, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code unknown;
    if (entry->is_symlink(unknown) || !entry->is_directory(unknown)) continue;
    const bool hidden = entry->path().filename().string().front() == '.';
    if (!hidden) folders.push_back(entry->path().string());
    if (hidden || entry.depth() + 1 >= kDeepest) entry.disable_recursion_pending();
  }
  return folders;
}

/// What a program that died has left is saved before anything else, without a question.
std::vector<std::string> SaveWhatWasLeft(const BoothdCommand& options, const KeySource* keys, CommandIo& io) {
  std::vector<std::string> notes;
  for (const std::string& folder : FoldersOf(options.recordings)) {
    const auto found = RecoverOpenRecordings(io.storage(), folder, keys);
    if (!found) notes.push_back(found.error().Text());
    if (!found) continue;
    for (const OpenRecording& one : *found) {
      notes.push_back(one.outcome ? "interrupted scan saved: " + one.recording + ": " + one.outcome->BriefReport()
                                  : one.outcome.error().Text());
      Log(LogLevel::kWarning, notes.back());
    }
  }
  return notes;
}

Status Serve(const BoothdCommand& options, CommandIo& io) {
  const auto config = ReadConfig(io.storage(), options.config);
  if (!config) return Fail(config);
  if (const Status sealed = CheckSealing(*config, options.key_file); !sealed) {
    io.set_failure_code(2);
    return sealed;
  }
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  RETURN_IF_ERROR(io.storage().CreateFolder(options.recordings));
  // First of all: a second boothd must not even look at the devices.
  auto socket = BoothSocket::Listen(options.socket);
  if (!socket) return Fail(socket);
  auto levels = LevelMailbox::Make();
  if (!levels) return Fail(levels);
  BoothSessionOptions session_options;
  session_options.pace = config->sim.real_time ? Pace::kRealTime : Pace::kPaced;
  session_options.scanner.recording.keys = keys->get();
  std::vector<std::string> notes = PrepareHost(*config, session_options.scanner);
  for (std::string& saved : SaveWhatWasLeft(options, keys->get(), io)) notes.push_back(std::move(saved));
  session_options.scanner.on_level = [raw = levels->get()](const ScanLevel& level) { raw->Put(level); };
  CalibrationGate gate(*config, io.storage());
  auto session = BoothSession::Open(*config, gate, io.storage(), std::move(session_options));
  if (!session) return Fail(session);
  ScannerPort port((*session)->scanner(), Describe(*config, **session),
                   {*config, io.storage(), options.recordings, std::move(notes)});
  auto server = BoothServer::Make(std::move(*socket), port, **levels);
  if (!server) return Fail(server);
  RETURN_IF_ERROR(io.Print("serving the booth on " + options.socket + "\n"));
  (*server)->Serve(io.stop());
  return {};  // what runs is stopped when the session ends
}

/// One question or order from the command line.
Status Ask(const BoothdCommand& options, CommandIo& io) {
  static const std::map<std::string, BoothOrder> kOrders{{"status", StatusOrder{}},
                                                         {"home", HomeOrder{}},
                                                         {"cancel", CancelOrder{}},
                                                         {"acknowledge", AcknowledgeOrder{}},
                                                         {"acknowledge-service", AcknowledgeOrder{}}};
  const bool control = options.ask != "status" && options.ask != "cancel";
  const BoothRole role = options.ask == "acknowledge-service" ? BoothRole::kTechnician : BoothRole::kOperator;
  auto client = BoothClient::Connect(options.socket, {role, control, "annulus boothd --ask"}, kConnectPatience);
  if (!client) return Fail(client);
  RETURN_IF_ERROR(client->Ask(kOrders.at(options.ask), kAskPatience));
  RETURN_IF_ERROR(client->Ask(StatusOrder{}, kAskPatience));
  return io.Print(EncodeMessage(client->status()) + "\n");
}

}  // namespace

void AddBoothdCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<BoothdCommand>();
  CLI::App* command = app.add_subcommand("boothd", "own the booth's devices and serve them on a socket, until Ctrl-C");
  command->add_option("--config", options->config, "the station's configuration; 'sim' is the built-in simulated booth")
      ->type_name("F")
      ->capture_default_str();
  command->add_option("--socket", options->socket, "Unix socket to serve")->type_name("PATH")->capture_default_str();
  command->add_option("--recordings", options->recordings, "folder of the recordings")
      ->type_name("DIR")
      ->capture_default_str();
  AddKeyFileOption(*command, options->key_file);
  command
      ->add_option(
          "--ask", options->ask,
          "ask the boothd that runs: status, home (moves the axis), cancel, acknowledge, or acknowledge-service for "
          "what only the service may; then print its status")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"status", "home", "cancel", "acknowledge", "acknowledge-service"}));
  command->footer(
      "The protocol is in docs/wire_protocol.md. SIGTERM stops what runs, and ends it.\n"
      "Example: annulus boothd --config booth.toml --recordings /var/lib/annulus --key-file /etc/annulus/keys");
  command->callback([&chosen, options] {
    chosen = [options](CommandIo& io) { return options->ask.empty() ? Serve(*options, io) : Ask(*options, io); };
  });
}

}  // namespace annulus
