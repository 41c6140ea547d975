#include "tests/console_whole/whole_station.h"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "station/console/accounts.h"
#include "station/console/consent_texts.h"
#include "station/key_file.h"
#include "station/profile_plan.h"
#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::chrono::seconds kPatience{60};

/// Causes by which a booth stops on a machine that is too busy for real time.
bool IsOfBusyMachine(CauseCode code) {
  switch (code) {
    case CauseCode::kHostLate:
    case CauseCode::kHostHang:
    case CauseCode::kThreadDead:
    case CauseCode::kFollowingError:
    case CauseCode::kAxisLink:
    case CauseCode::kSensorLost:
      return true;
    default:
      return false;
  }
}

/// Down the head of the simulated body, once, and in three sweeps.
Config ShortScans() {
  Config config = SimulatedConfig();
  ProfileConfig profile;
  profile.z_top_mm = 1700.0;
  profile.z_bottom_mm = 1200.0;
  profile.pitch_mm = 5.0;
  profile.speed_mm_s = 60.0;
  profile.sweeps = 1;
  profile.level_rate_hz = 20.0;
  config.profiles["short"] = profile;
  profile.z_bottom_mm = 1000.0;
  profile.pitch_mm = 4.0;
  profile.speed_mm_s = 120.0;
  profile.sweeps = 3;
  profile.level_rate_hz = 30.0;
  config.profiles["long"] = profile;
  return config;
}

ConsoleServerOptions ConsoleOptions(const FreshFolder& folder, const std::vector<std::string>& remote) {
  ConsoleServerOptions options;
  options.config = ShortScans();
  options.config_path = "sim";
  options.folder = folder / "store";
  options.config.store.folder = options.folder;
  options.config.store.recordings = folder / "recordings";
  options.remote = remote;
  options.port = 0;
  options.booth_socket = folder / "booth.sock";
  // What comes of a scan is not looked at here.
  options.job_program = folder / "no_fit";
  std::ofstream(options.job_program) << "#!/bin/sh\nexit 1\n";
  ::chmod(options.job_program.c_str(), 0700);
  return options;
}

BoothDescription Describe(const Config& config, const BoothSession& session) {
  BoothDescription booth;
  booth.station_id = "whole";
  booth.simulated = true;
  booth.ring_radius_mm = config.ring.radius_mm;
  booth.axis = session.axis().identity().limits;
  booth.profiles = ProfileNames(config);
  return booth;
}

template <class Value>
Value Must(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().Text());
  return std::move(*result);
}

}  // namespace

bool IsIdle(const ScannerStatus& status) { return status.state == ScanState::kIdle && status.job.empty(); }

Boothd::Boothd(const Config& config, Pace pace, const std::string& recordings, const KeySource* keys,
               const std::string& socket)
    : mailbox_(Must(LevelMailbox::Make())) {
  BoothSessionOptions options;
  options.pace = pace;
  options.scanner.recording.keys = keys;
  options.scanner.on_level = [this](const ScanLevel& level) {
    mailbox_->Put(level);
    const std::lock_guard lock(mutex_);
    taken_[{level.sweep, level.index}] = SystemClock().Now();
  };
  options.on_tick = [this, last = nanoseconds(0)](nanoseconds now) mutable {
    const std::lock_guard lock(mutex_);
    if (last > nanoseconds(0)) ticks_.push_back(now - last);
    last = now;
  };
  auto listening = Must(BoothSocket::Listen(socket));
  session_ = Must(BoothSession::Open(config, gate_, storage_, std::move(options)));
  port_ = std::make_unique<ScannerPort>(session_->scanner(), Describe(config, *session_),
                                        ScannerPortOptions{config, storage_, recordings, {}});
  server_ = Must(BoothServer::Make(std::move(listening), *port_, *mailbox_));
  serving_ = std::jthread([this](const std::stop_token& stop) { server_->Serve(stop); });
  if (pace == Pace::kRealTime) looking_ = std::jthread([this](const std::stop_token& stop) { Look(stop); });
}

Boothd::~Boothd() {
  looking_ = {};
  serving_ = {};
  session_.reset();  // stops what runs; its threads call back until then
}

/// A cause may be gone again before a test looks: the automatic operator resets.
void Boothd::Look(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    for (const ScanCause& cause : status().causes) {
      if (!IsOfBusyMachine(cause.code)) continue;
      const std::lock_guard lock(mutex_);
      if (busy_.empty()) busy_ = cause.text;
    }
    std::this_thread::sleep_for(milliseconds(5));
  }
}

std::map<Boothd::LevelName, nanoseconds> Boothd::Taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

std::vector<nanoseconds> Boothd::TakeTicks() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ticks_, {});
}

void Boothd::Wait(const std::string& what, const std::function<bool(const ScannerStatus&)>& wanted) {
  const auto busy = [this] {
    const std::lock_guard lock(mutex_);
    return busy_;
  };
  const bool there = Eventually([&] { return wanted(status()) || !busy().empty(); }, kPatience);
  if (!busy().empty()) throw TooBusy(what + ": " + busy());
  if (there) return;
  const ScannerStatus now = status();
  throw std::runtime_error(what + ": " + ScanStateText(now.state) +
                           (now.causes.empty() ? "" : ", " + now.causes.front().text));
}

WholeStation::WholeStation(Pace pace, const std::vector<std::string>& remote)
    : options_(ConsoleOptions(folder_, remote)) {
  console_ = Must(ConsoleServer::Open(options_, storage_, clock));
  for (const auto& [name, role] :
       {std::pair("anna", StationRole::kOperator), std::pair("boris", StationRole::kOperator),
        std::pair("tessa", StationRole::kTechnician), std::pair("ada", StationRole::kAdmin)}) {
    if (const Status added = console_->accounts().Add(name, role, kPassword); !added) {
      throw std::runtime_error(added.error().Text());
    }
  }
  keys_ = Must(ReadKeyFile(StationKeyFile(options_)));
  booth_ = std::make_unique<Boothd>(options_.config, pace, options_.config.store.recordings, keys_.get(),
                                    options_.booth_socket);
  if (const Status listens = console_->Listen(); !listens) throw std::runtime_error(listens.error().Text());
}

WholeStation::~WholeStation() { console_.reset(); }

void WholeStation::RestartConsole(const std::function<void()>& meanwhile) {
  console_.reset();
  meanwhile();
  console_ = Must(ConsoleServer::Open(options_, storage_, clock));
  if (const Status listens = console_->Listen(); !listens) throw std::runtime_error(listens.error().Text());
}

RawTarget WholeStation::target() const {
  std::ifstream file(folder_ / "store/tls/authority.pem");
  RawTarget target;
  target.port = console_->port();
  target.authority_pem = {std::istreambuf_iterator<char>(file), {}};
  return target;
}

StartedScan WholeStation::StartScan(ConsoleBrowser& browser, const std::string& profile) {
  const auto post = [&](const std::string& path, const json& body = json::object()) {
    const auto answer = browser.Post(path, body);
    if (answer.status != 200) throw std::runtime_error(path + ": " + answer.json.dump());
    return answer.json;
  };
  booth().Wait("reset", IsIdle);
  if (!Eventually([&] { return browser.Get("/api/booth").json.value("connected", false); })) {
    throw std::runtime_error("the console does not reach the booth");
  }
  post("/api/booth/home");
  booth().Wait("home", [](const ScannerStatus& status) { return status.homed && IsIdle(status); });
  StartedScan scan;
  scan.customer_id = post("/api/customers", {{"name", "Hanako"}, {"height_mm", 1700}}).at("id");
  scan.consent_id =
      post("/api/customers/" + scan.customer_id + "/consents",
           {{"purposes", {"measure"}}, {"text_version", ConsentTextVersion()}, {"language", "en"}, {"agreed", true}})
          .at("id");
  post("/api/booth/arm", {{"customer_id", scan.customer_id}, {"consent_id", scan.consent_id}, {"profile", profile}});
  // Not while it still works on the order, nor before the key was pressed.
  booth().Wait("start", [&](const ScannerStatus& status) {
    return status.start_agreed && status.job.empty() &&
           browser.Post("/api/booth/start", {{"version", status.version}}).status == 200;
  });
  booth().Wait("first levels", [&](const ScannerStatus&) { return booth().Taken().size() >= 3; });
  return scan;
}

ScanRow WholeStation::WaitTakenIn(const StartedScan& scan) {
  booth().Wait("end of the scan", IsIdle);
  std::vector<ScanRow> rows;
  const bool there = Eventually(
      [&] {
        rows = Must(console().store().ScansOf(scan.customer_id));
        return !rows.empty();
      },
      kPatience);
  if (!there) throw std::runtime_error("the scan does not come into the store");
  return rows.front();
}

std::vector<Boothd::LevelName> WholeStation::Recorded(const std::string& scan_id) {
  const auto bytes = Must(console().store().ReadRecording(scan_id));
  const Recording recording = Must(ParseRecording(bytes, scan_id));
  std::vector<Boothd::LevelName> names;
  for (const ScanLevel& level : recording.scan.levels) names.emplace_back(level.sweep, level.index);
  return names;
}

}  // namespace annulus::test
