#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "station/http/http_server.h"
#include "tests/station_http/raw_client.h"

namespace annulus::test {

/// Polls until `condition` holds, leaving the processor to others in between; false after `patience`.
inline bool Eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds patience = std::chrono::seconds(10)) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// A handler that keeps what it is given. `answer` and `open` may be replaced before the server starts.
class KeepingHandler final : public HttpHandler {
 public:
  std::function<HttpResponse(const HttpRequest&)> answer = [](const HttpRequest& request) {
    return HttpResponse{200, "text/plain", {}, request.method + " " + request.path + " " + request.body};
  };
  std::function<std::optional<HttpResponse>(const HttpRequest&)> open = [](const HttpRequest&) {
    return std::optional<HttpResponse>();
  };
  /// Called with each text; nothing by itself.
  std::function<void(WebSocketPeer&, std::string_view)> receive = [](WebSocketPeer&, std::string_view) {};

  HttpResponse Handle(const HttpRequest& request) override {
    {
      const std::lock_guard lock(mutex_);
      requests_.push_back(request);
    }
    return answer(request);
  }
  std::optional<HttpResponse> Open(const HttpRequest& request, const std::shared_ptr<WebSocketPeer>& peer) override {
    auto refusal = open(request);
    const std::lock_guard lock(mutex_);
    if (!refusal) peers_.push_back(peer);
    return refusal;
  }
  void Received(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text) override {
    receive(*peer, text);
    const std::lock_guard lock(mutex_);
    texts_.emplace_back(text);
  }
  void Closed(const std::shared_ptr<WebSocketPeer>& peer) override {
    const std::lock_guard lock(mutex_);
    closed_.push_back(peer);
  }
  void Refused(const std::string& peer, const std::string& reason) override {
    const std::lock_guard lock(mutex_);
    refusals_.push_back(peer + ": " + reason);
  }

  [[nodiscard]] std::vector<HttpRequest> requests() const { return Copy(requests_); }
  [[nodiscard]] std::vector<std::shared_ptr<WebSocketPeer>> peers() const { return Copy(peers_); }
  [[nodiscard]] std::vector<std::shared_ptr<WebSocketPeer>> closed() const { return Copy(closed_); }
  [[nodiscard]] std::vector<std::string> texts() const { return Copy(texts_); }
  [[nodiscard]] std::vector<std::string> refusals() const { return Copy(refusals_); }

 private:
  template <class T>
  T Copy(const T& list) const {
    const std::lock_guard lock(mutex_);
    return list;
  }

  mutable std::mutex mutex_;
  std::vector<HttpRequest> requests_;
  std::vector<std::shared_ptr<WebSocketPeer>> peers_;
  std::vector<std::shared_ptr<WebSocketPeer>> closed_;
  std::vector<std::string> texts_;
  std::vector<std::string> refusals_;
};

/// A server on loopback, without TLS unless a test says so, with limits of requests that no test meets by accident.
class HttpTest : public testing::Test {
 protected:
  HttpTest() {
    options.addresses = {"127.0.0.1"};
    options.limits.requests_per_second = 1e6;
    options.limits.burst = 1e6;
  }

  void Start() {
    auto made = HttpServer::Make(options, handler);
    ASSERT_TRUE(made.has_value()) << made.error().Text();
    server = std::move(*made);
    target.port = server->port();
  }
  std::unique_ptr<RawClient> Client() {
    auto client = RawClient::Connect(target);
    EXPECT_NE(client, nullptr);
    return client;
  }

  HttpServerOptions options;
  KeepingHandler handler;
  RawTarget target;
  std::unique_ptr<HttpServer> server;
};

}  // namespace annulus::test
