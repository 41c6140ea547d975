// How soon a level that boothd takes is with the browsers (must: within 100 ms, p99).

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/storage.h"
#include "station/booth_server.h"
#include "station/console/accounts.h"
#include "station/console/booth_live.h"
#include "station/console/console_server.h"
#include "station/console/live_hub.h"
#include "tests/console_whole/console_browser.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// A booth that only stands there.
class StillPort final : public BoothPort {
 public:
  StillPort() { description_.ring_radius_mm = 600.0; }
  [[nodiscard]] const BoothDescription& description() const override { return description_; }
  Status Home() override { return {}; }
  Status Arm(const ArmOrder&) override { return {}; }
  Status Start(std::uint64_t) override { return {}; }
  Status Cancel() override { return {}; }
  Status Acknowledge(CauseRole) override { return {}; }
  Status Jog(Scanner::JogDirection) override { return {}; }
  [[nodiscard]] ScannerStatus status() const override { return {}; }

 private:
  BoothDescription description_;
};

/// Notes when each level comes to be sent.
class TimingHub final : public LiveHub {
 public:
  void Join(const std::shared_ptr<WebSocketPeer>&, const Caller&) override {}
  void Leave(const std::shared_ptr<WebSocketPeer>&) override {}
  void Send(const nlohmann::ordered_json& message, RouteRoles, bool) override {
    const std::string& type = message.at("type").get_ref<const std::string&>();
    const std::lock_guard lock(mutex_);
    if (type == "status") connected_ = true;
    if (type == "level") came_[message.at("level")] = SystemClock().Now();
    changed_.notify_all();
  }
  void SendTo(const std::string&, const nlohmann::ordered_json&) override {}
  void End(const std::string&) override {}

  void WaitConnected() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return connected_; });
  }
  nanoseconds WaitLevel(std::uint32_t level) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return came_.contains(level); });
    return came_[level];
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool connected_ = false;
  std::map<std::uint32_t, nanoseconds> came_;
};

ScanLevel WholeLevel(std::uint32_t index) {
  ScanLevel level{index, 0, nanoseconds(1), {}};
  for (int sensor = 0; sensor < 180; ++sensor) level.readings.push_back({412.34 + sensor, 1000.0, 200});
  return level;
}

void ReportLatency(benchmark::State& state, std::vector<double> latency_ms) {
  if (latency_ms.empty()) return;
  std::sort(latency_ms.begin(), latency_ms.end());
  const auto at = [&](double share) {
    return latency_ms[static_cast<std::size_t>(share * static_cast<double>(latency_ms.size() - 1))];
  };
  state.counters["levels"] = static_cast<double>(latency_ms.size());
  state.counters["p50_ms"] = at(0.5);
  state.counters["p99_ms"] = at(0.99);
  state.counters["max_ms"] = at(1.0);
}

/// From the level in boothd's mailbox to LiveHub::Send, through socket, link and JSON, at 30 levels a second and
/// faster.
void LevelToBrowsers(benchmark::State& state) {
  const auto folder = std::filesystem::temp_directory_path() / ("annulus_live_bench_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  auto levels = LevelMailbox::Make();
  auto socket = BoothSocket::Listen((folder / "booth.sock").string());
  if (!levels || !socket) throw std::runtime_error("no socket");
  StillPort port;
  auto server = BoothServer::Make(std::move(*socket), port, **levels);
  std::jthread serving([&](const std::stop_token& stop) { (*server)->Serve(stop); });
  TimingHub hub;
  const SystemClock clock;
  BoothLive live(hub, clock);
  const auto link = BoothLink::Make((folder / "booth.sock").string(), live.events());
  hub.WaitConnected();

  std::vector<double> latency_ms;
  std::uint32_t index = 0;
  for (auto _ : state) {
    const nanoseconds put = clock.Now();
    (*levels)->Put(WholeLevel(index));
    latency_ms.push_back(std::chrono::duration<double, std::milli>(hub.WaitLevel(index) - put).count());
    ++index;
  }
  ReportLatency(state, std::move(latency_ms));
  serving.request_stop();
  serving.join();
  std::filesystem::remove_all(folder);
}
BENCHMARK(LevelToBrowsers)->Iterations(2000)->UseRealTime()->Unit(benchmark::kMillisecond);

/// A console, whole, in front of a booth that only gives levels.
class LiveConsole {
 public:
  LiveConsole() {
    std::filesystem::create_directories(folder_);
    auto socket = BoothSocket::Listen((folder_ / "booth.sock").string());
    auto levels = LevelMailbox::Make();
    if (!levels || !socket) throw std::runtime_error("no socket");
    levels_ = std::move(*levels);
    server_ = std::move(*BoothServer::Make(std::move(*socket), port_, *levels_));
    serving_ = std::jthread([this](const std::stop_token& stop) { server_->Serve(stop); });
    ConsoleServerOptions options;
    options.config = SimulatedConfig();
    options.folder = (folder_ / "store").string();
    options.config.store.recordings = (folder_ / "recordings").string();
    options.port = 0;
    options.booth_socket = (folder_ / "booth.sock").string();
    console_ = std::move(*ConsoleServer::Open(std::move(options), storage_, clock_));
    if (!console_->accounts().Add("anna", StationRole::kOperator, test::kPassword) || !console_->Listen()) {
      throw std::runtime_error("no console");
    }
  }
  ~LiveConsole() {
    console_.reset();
    serving_ = {};
    std::filesystem::remove_all(folder_);
  }
  LiveConsole(const LiveConsole&) = delete;
  LiveConsole& operator=(const LiveConsole&) = delete;

  LevelMailbox& levels() { return *levels_; }
  /// A browser that is logged in.
  [[nodiscard]] test::ConsoleBrowser Browser() const {
    std::ifstream file(folder_ / "store/tls/authority.pem");
    test::RawTarget target;
    target.port = console_->port();
    target.authority_pem = {std::istreambuf_iterator<char>(file), {}};
    test::ConsoleBrowser browser(target);
    if (browser.LogIn("anna").status != 200) throw std::runtime_error("no login");
    return browser;
  }

 private:
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("annulus_live_console_" + std::to_string(::getpid()));
  SystemClock clock_;
  PosixStorage storage_;
  StillPort port_;
  std::unique_ptr<LevelMailbox> levels_;
  std::unique_ptr<BoothServer> server_;
  std::jthread serving_;
  std::unique_ptr<ConsoleServer> console_;
};

/// Must: p99 100 ms. A scan of 1000 levels of 180 readings, 50 a second (the design case), from boothd's mailbox to so
/// many browsers that are logged in, over unix socket, link, hub, TLS and WebSocket; the times are of all browsers.
void LevelToTlsBrowsers(benchmark::State& state) {
  constexpr std::uint32_t kLevels = 1000;
  constexpr std::chrono::milliseconds kPeriod{20};
  LiveConsole console;
  test::ConsoleBrowser browser = console.Browser();
  while (!browser.Get("/api/booth").json.value("connected", false)) std::this_thread::yield();
  std::vector<std::unique_ptr<test::LiveListener>> listeners;
  for (int i = 0; i < state.range(0); ++i) {
    listeners.push_back(std::make_unique<test::LiveListener>(browser.OpenLive()));
    static_cast<void>(listeners.back()->WaitFor("status"));
  }
  SystemClock clock;
  std::vector<nanoseconds> put;
  for (auto _ : state) {
    nanoseconds next = clock.Now();
    for (std::uint32_t index = 0; index < kLevels; ++index) {
      clock.SleepUntil(next += kPeriod);
      put.push_back(clock.Now());
      console.levels().Put(WholeLevel(index));
    }
    clock.SleepUntil(next + 10 * kPeriod);  // for the last of them
  }
  std::vector<double> latency_ms;
  for (const auto& listener : listeners) {
    for (const auto& heard : listener->All()) {
      if (heard.message.at("type") != "level") continue;
      const nanoseconds took = heard.time - put.at(heard.message.at("level").get<std::size_t>());
      latency_ms.push_back(std::chrono::duration<double, std::milli>(took).count());
    }
  }
  ReportLatency(state, std::move(latency_ms));
}
BENCHMARK(LevelToTlsBrowsers)
    ->ArgName("browsers")
    ->Arg(1)
    ->Arg(20)
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus
