/// The console's HTTP server over TLS on loopback: requests on connections that stay open, and a live level to twenty
/// browsers. Clients are in the same process (tests/station_http/raw_client.h), so their work is in the times too.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/ensure.h"
#include "station/http/http_server.h"
#include "station/http/tls_identity.h"
#include "tests/station_http/raw_client.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using SteadyClock = std::chrono::steady_clock;

class BenchHandler final : public HttpHandler {
 public:
  HttpResponse Handle(const HttpRequest& /*request*/) override { return {200, "application/json", {}, "{}"}; }
  std::optional<HttpResponse> Open(const HttpRequest& /*request*/,
                                   const std::shared_ptr<WebSocketPeer>& peer) override {
    const std::lock_guard lock(mutex_);
    peers_.push_back(peer);
    return std::nullopt;
  }
  void Received(const std::shared_ptr<WebSocketPeer>& /*peer*/, std::string_view /*text*/) override {}
  void Closed(const std::shared_ptr<WebSocketPeer>& /*peer*/) override {}
  void Refused(const std::string& /*peer*/, const std::string& /*reason*/) override {}
  std::vector<std::shared_ptr<WebSocketPeer>> peers() {
    const std::lock_guard lock(mutex_);
    return peers_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::shared_ptr<WebSocketPeer>> peers_;
};

/// A server with TLS and without limits of requests.
struct BenchServer {
  BenchServer() {
    test::TestStorage storage;
    const SystemClock clock;
    const auto identity = OpenTlsIdentity(storage, "tls", {}, clock);
    ENSURE(identity.has_value(), "an identity is made in memory");
    HttpServerOptions options;
    options.addresses = {"127.0.0.1"};
    options.certificate_pem = identity->certificate_pem;
    options.private_key_pem = identity->private_key_pem;
    options.limits.requests_per_second = 1e9;
    options.limits.burst = 1e9;
    auto made = HttpServer::Make(options, handler);
    ENSURE(made.has_value(), "the server listens on loopback");
    server = std::move(*made);
    target.port = server->port();
    target.authority_pem = identity->authority_pem;
  }
  BenchHandler handler;
  std::unique_ptr<HttpServer> server;
  test::RawTarget target;
};

void ReportTimes(benchmark::State& state, std::vector<double> times_us) {
  if (times_us.empty()) return;
  std::sort(times_us.begin(), times_us.end());
  state.counters["p50_us"] = times_us[times_us.size() / 2];
  state.counters["p99_us"] = times_us[times_us.size() * 99 / 100];
}

double MicrosecondsSince(SteadyClock::time_point begin) {
  return std::chrono::duration<double, std::micro>(SteadyClock::now() - begin).count();
}

void BM_HttpsKeepAlive(benchmark::State& state) {
  BenchServer bench;
  const auto client = test::RawClient::Connect(bench.target);
  std::vector<double> times_us;
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = SteadyClock::now();
    ENSURE(client->Ask(test::Get("/api/session")).status == 200, "the server answers");
    times_us.push_back(MicrosecondsSince(begin));
  }
  state.SetItemsProcessed(state.iterations());
  ReportTimes(state, std::move(times_us));
}
BENCHMARK(BM_HttpsKeepAlive)->UseRealTime()->Unit(benchmark::kMicrosecond);

void BM_HttpsNewConnection(benchmark::State& state) {
  BenchServer bench;
  std::vector<double> times_us;
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = SteadyClock::now();
    const auto client = test::RawClient::Connect(bench.target);
    ENSURE(client && client->Ask(test::Get("/", "Connection: close\r\n")).status == 200, "the server answers");
    times_us.push_back(MicrosecondsSince(begin));
  }
  state.SetItemsProcessed(state.iterations());
  ReportTimes(state, std::move(times_us));
}
BENCHMARK(BM_HttpsNewConnection)->UseRealTime()->Unit(benchmark::kMicrosecond);

/// One level as JSON, about 2 KB, to twenty clients: from the call until the last of them has it.
void BM_LiveLevelToTwentyClients(benchmark::State& state) {
  BenchServer bench;
  std::vector<std::unique_ptr<test::RawClient>> clients;
  for (int i = 0; i < 20; ++i) {
    clients.push_back(test::RawClient::Connect(bench.target));
    ENSURE(clients.back()->OpenWebSocket().status == 101, "a WebSocket opens");
  }
  const auto peers = bench.handler.peers();
  const auto level = std::make_shared<const std::string>(2048, 'x');
  std::vector<double> times_us;
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = SteadyClock::now();
    for (const auto& peer : peers) peer->SendText(level);
    for (const auto& client : clients) ENSURE(client->ReadFrame().payload.size() == level->size(), "a level comes");
    times_us.push_back(MicrosecondsSince(begin));
  }
  state.SetItemsProcessed(state.iterations() * 20);
  ReportTimes(state, std::move(times_us));
}
BENCHMARK(BM_LiveLevelToTwentyClients)->UseRealTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace annulus
