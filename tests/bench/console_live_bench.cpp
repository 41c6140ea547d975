// How soon a level that boothd sends is on its way to the browsers (issue 10: in the browser within 100 ms, p99).

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "station/booth_server.h"
#include "station/console/booth_live.h"
#include "station/console/live_hub.h"

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
  std::sort(latency_ms.begin(), latency_ms.end());
  const auto at = [&](double share) {
    return latency_ms[static_cast<std::size_t>(share * static_cast<double>(latency_ms.size() - 1))];
  };
  state.counters["p50_ms"] = at(0.5);
  state.counters["p99_ms"] = at(0.99);
  state.counters["max_ms"] = at(1.0);
  serving.request_stop();
  serving.join();
  std::filesystem::remove_all(folder);
}
BENCHMARK(LevelToBrowsers)->Iterations(2000)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus
