// serve: the operator's console, for browsers on the booth's own screen (and, if told so, from afar).

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

#include "base/clock.h"
#include "base/log.h"
#include "sim/unix_socket.h"
#include "station/booth_socket.h"
#include "station/commands.h"
#include "station/config.h"
#include "station/console/accounts.h"
#include "station/console/booth_process.h"
#include "station/console/console_server.h"
#include "station/console/passwords.h"
#include "station/console/privileges.h"
#include "station/console/static_files.h"
#include "station/devices.h"
#include "station/store/store.h"

namespace annulus {
namespace {

constexpr std::chrono::milliseconds kLook{50};  ///< At a stop request.
constexpr std::chrono::seconds kTick{1};

struct ServeCommand {
  std::string config;
  bool simulated = false;
  std::optional<int> port;
  std::string folder;
  std::string socket;
  std::string web;
  bool reset_passwords = false;
  std::string password_file;
  bool allow_root = false;
};

/// Where a simulated console keeps its things unless told otherwise.
std::string SimulatedFolder() {
  if (const char* data = std::getenv("XDG_DATA_HOME"); data != nullptr && *data == '/') {
    return std::string(data) + "/annulus-simulated";
  }
  const char* home = std::getenv("HOME");
  return (home != nullptr && *home == '/' ? std::string(home) : "/var/tmp") + "/.local/share/annulus-simulated";
}

/// One console serves a folder at a time; the kernel lets go of it however we end.
Result<sim::OwnedFd> LockFolder(const std::string& folder) {
  const std::string path = folder + "/console.lock";
  sim::OwnedFd lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (lock.get() < 0) return Fail("lock " + path, std::strerror(errno), "give a folder of your own with --folder");
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    return Fail("lock " + path, "another console serves this folder", "end it, or give another --folder");
  }
  return lock;
}

/// The folder is for us alone: customers' data lie in it, sealed, beside the key.
Status PrepareFolder(Storage& storage, const std::string& folder) {
  RETURN_IF_ERROR(storage.CreateFolder(folder));
  struct stat found {};
  if (::stat(folder.c_str(), &found) != 0 || found.st_uid != ::geteuid()) {
    return Fail("use folder " + folder, "it is not ours", "give a folder of your own with --folder");
  }
  if (::chmod(folder.c_str(), 0700) != 0) return Fail("use folder " + folder, std::strerror(errno), "give another");
  return {};
}

/// Passwords by user, of a file with a line "NAME PASSWORD" each.
Result<std::map<std::string, std::string>> ReadPasswordFile(Storage& storage, const std::string& path) {
  std::map<std::string, std::string> passwords;
  if (path.empty()) return passwords;
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  std::istringstream lines(*text);
  std::string line;
  while (std::getline(lines, line)) {
    const std::size_t blank = line.find(' ');
    if (line.empty() || line.front() == '#') continue;
    if (blank == std::string::npos) return Fail("read " + path, "a line is not NAME PASSWORD", "correct it");
    passwords[line.substr(0, blank)] = line.substr(blank + 1);
  }
  return passwords;
}

/// The three accounts of a simulated station: made at the first start, with passwords that are told then, and again
/// only if they are made anew. Returns what to print.
Result<std::string> PrepareSimulatedAccounts(const ServeCommand& command, ConsoleServer& console, Storage& storage) {
  Accounts& accounts = console.accounts();
  if (console.store().state() == StoreState::kReadOnly) return std::string();  // those that are there may still log in
  const auto given = ReadPasswordFile(storage, command.password_file);
  if (!given) return Fail(given);
  const auto empty = accounts.Empty();
  if (!empty) return Fail(empty);
  if (!*empty && !command.reset_passwords && given->empty()) {
    return std::string(
        "accounts:    operator, technician, admin; forgotten a password? start once with --reset-passwords\n");
  }
  std::string table;
  const std::pair<const char*, StationRole> all[] = {
      {"operator", StationRole::kOperator}, {"technician", StationRole::kTechnician}, {"admin", StationRole::kAdmin}};
  for (const auto& [name, role] : all) {
    const auto chosen = given->find(name);
    if (!*empty && !command.reset_passwords && chosen == given->end()) continue;
    const std::string password = chosen == given->end() ? RandomPassword() : chosen->second;
    Status set = accounts.Add(name, role, password);
    if (!set) set = accounts.SetPassword(name, password);  // it is there
    if (!set) return Fail(set);
    if (chosen == given->end()) table += fmt::format("             {:<11} {}\n", name, password);
  }
  return table.empty() ? table : "accounts, and their passwords, which are not shown again:\n" + table;
}

/// What a console for real people needs before it may be reached from afar.
Status CheckRemote(const ConsoleServerOptions& options, Accounts& accounts) {
  if (options.remote.empty()) return {};
  const auto admin = accounts.HasAdmin();
  if (!admin) return Fail(admin);
  if (*admin) return {};
  return Fail("serve " + options.remote.front(), "there is no admin with a password yet",
              "start without [console] addresses, set the station up on its own screen, then start again");
}

/// Nobody works as root by accident.
Status CheckRoot(const ServeCommand& command, CommandIo& io) {
  if (command.simulated || command.allow_root || !IsRoot()) return {};
  io.set_failure_code(2);
  return Fail("serve a real station", "this process runs as root, and a console needs no rights",
              "start it as a user of its own (systemd: User=annulus), or with --allow-root");
}

std::string BoothSocketName(const ServeCommand& command, const std::string& folder) {
  if (!command.socket.empty()) return command.socket;
  if (!command.simulated) return DefaultBoothSocket();
  // A name of this process: the booth of a console that was killed may still be ending.
  constexpr std::size_t kLongestSocketName = 100;
  const std::string name = fmt::format("/booth-{}.sock", ::getpid());
  if (folder.size() + name.size() <= kLongestSocketName) return folder + name;
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  return (runtime != nullptr && *runtime == '/' ? std::string(runtime) : "/tmp") + "/annulus" + name.substr(1);
}

Result<ConsoleServerOptions> ReadOptions(const ServeCommand& command, CommandIo& io) {
  auto config = ReadConfig(io.storage(), command.simulated ? "sim" : command.config);
  if (!config) return Fail(config);
  ConsoleServerOptions options;
  options.config = std::move(*config);
  options.config_path = command.simulated ? "sim" : std::filesystem::absolute(command.config).string();
  options.folder = command.folder;
  if (options.folder.empty()) options.folder = command.simulated ? SimulatedFolder() : options.config.store.folder;
  if (options.folder.empty()) {
    io.set_failure_code(2);
    return Fail("serve " + command.config, "it does not say where the store is", "give folder in [store], or --folder");
  }
  options.folder = std::filesystem::absolute(options.folder).string();
  options.config.store.folder = options.folder;
  options.config.store.recordings = RecordingsFolder(options.config.store);
  if (options.config.store.key_file.empty()) options.config.store.key_file = StationKeyFile(options);
  options.remote = options.config.console.addresses;
  options.port = static_cast<std::uint16_t>(command.port.value_or(options.config.console.port));
  options.booth_socket = BoothSocketName(command, options.folder);
  options.web_folder = command.web.empty() ? DefaultWebFolder() : command.web;
  return options;
}

Result<std::unique_ptr<BoothProcess>> StartBooth(const ServeCommand& command, const ConsoleServerOptions& options) {
  if (!command.simulated || !command.socket.empty()) return std::unique_ptr<BoothProcess>();
  return BoothProcess::Start(options.booth_socket, {"--config", "sim", "--recordings", options.config.store.recordings,
                                                    "--key-file", options.config.store.key_file});
}

/// Until a stop is asked for. A simulated booth that ended is started again.
Status ServeUntilStopped(const ServeCommand& command, const ConsoleServerOptions& options, ConsoleServer& console,
                         std::unique_ptr<BoothProcess>& booth, const std::stop_token& stop) {
  SystemClock clock;
  auto next_tick = clock.Now();
  while (!stop.stop_requested()) {
    if (clock.Now() >= next_tick) {
      next_tick = clock.Now() + kTick;
      console.Tick();
      if (booth != nullptr && !booth->runs()) {
        Log(LogLevel::kWarning, "the simulated booth has ended; it is started again");
        auto again = StartBooth(command, options);
        if (!again) return Fail(again);
        booth = std::move(*again);
      }
    }
    std::this_thread::sleep_for(kLook);
  }
  if (booth != nullptr) booth->RequestStop();  // it ends while the console does
  return {};
}

std::string Greeting(const ConsoleServer& console, const std::string& accounts, bool simulated) {
  std::string text = fmt::format("console:     https://localhost:{}\n", console.port());
  text += "certificate: its own authority, SHA-256 " + console.fingerprint() + "\n";
  text += accounts;
  for (const std::string& note : console.notes()) text += "note:        " + note + "\n";
  text +=
      simulated
          ? "first:       open the address in a browser on this machine, accept the certificate after comparing it, "
            "log in as operator\n"
          : "first:       open the address in the booth's own browser; a new station asks for its first admin\n";
  return text + "Ctrl-C ends it.\n";
}

Status Serve(const ServeCommand& command, CommandIo& io) {
  RETURN_IF_ERROR(CheckRoot(command, io));
  auto options = ReadOptions(command, io);
  if (!options) return Fail(options);
  ::umask(0077);
  RETURN_IF_ERROR(PrepareFolder(io.storage(), options->folder));
  const auto lock = LockFolder(options->folder);
  if (!lock) return Fail(lock);
  SystemClock clock;
  auto console = ConsoleServer::Open(*options, io.storage(), clock);
  if (!console) return Fail(console);
  auto booth = StartBooth(command, *options);  // before there are threads
  if (!booth) return Fail(booth);
  std::string accounts;
  if (command.simulated) {
    auto prepared = PrepareSimulatedAccounts(command, **console, io.storage());
    if (!prepared) return Fail(prepared);
    accounts = std::move(*prepared);
  }
  RETURN_IF_ERROR(CheckRemote(*options, (*console)->accounts()));
  RETURN_IF_ERROR((*console)->Listen());
  RETURN_IF_ERROR(GiveUpPrivileges());
  RETURN_IF_ERROR(io.Print(Greeting(**console, accounts, command.simulated)));
  return ServeUntilStopped(command, *options, **console, *booth, io.stop());
}

}  // namespace

void AddServeCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ServeCommand>();
  CLI::App* command = app.add_subcommand("serve", "the operator's console, for a browser, until Ctrl-C");
  CLI::Option* config = command->add_option("--config", options->config, "the station's configuration")->type_name("F");
  CLI::Option* simulated =
      command->add_flag("--simulated", options->simulated, "a station with a simulated booth, to try out everything");
  simulated->excludes(config);
  command->add_option("--port", options->port, "port on this machine; 0 is any that is free (8437)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  command->add_option("--folder", options->folder, "folder of store, keys and certificate")->type_name("DIR");
  command->add_option("--socket", options->socket, "Unix socket of boothd; with --simulated: one that runs already")
      ->type_name("PATH");
  command->add_option("--web", options->web, "folder of the page, as 'npm run build' wrote it (web beside the program)")
      ->type_name("DIR");
  command->add_flag("--reset-passwords", options->reset_passwords, "new passwords for the simulated station's accounts")
      ->needs(simulated);
  command
      ->add_option("--password-file", options->password_file,
                   "passwords of the simulated station's accounts, lines NAME PASSWORD")
      ->type_name("FILE")
      ->needs(simulated);
  command->add_flag("--allow-root", options->allow_root, "run a real station as root all the same");
  command->footer(
      "It listens on this machine only, unless [console] addresses says otherwise (docs/config.md, docs/security.md).\n"
      "Example: annulus serve --simulated");
  command->callback([&chosen, options] {
    if (!options->simulated && options->config.empty()) {
      throw CLI::RequiredError("--config F, or --simulated,");
    }
    chosen = [options](CommandIo& io) { return Serve(*options, io); };
  });
}

}  // namespace annulus
