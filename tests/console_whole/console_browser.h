#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/station_http/raw_client.h"

namespace annulus::test {

/// What `browsers` of a test log in with.
inline constexpr const char* kPassword = "tidal crumbs vexed orbit";

/// A browser at the console's port: keeps cookie and CSRF token, sends what the page sends. Every request on a
/// connection of its own. Thread-bound.
class ConsoleBrowser {
 public:
  explicit ConsoleBrowser(RawTarget target);

  struct Answer {
    int status = 0;  ///< 0: none came.
    nlohmann::json json;
    std::chrono::milliseconds took{0};  ///< With the handshake.
  };
  Answer Get(const std::string& path);
  Answer Post(const std::string& path, const nlohmann::json& body = nlohmann::json::object());
  /// As the page does it: asks for the session, then logs in.
  Answer LogIn(const std::string& user);

  /// A request as it would be sent.
  [[nodiscard]] std::string GetText(const std::string& path) const;
  [[nodiscard]] std::string PostText(const std::string& path, const nlohmann::json& body) const;
  /// Opens /api/live with this session; null if it was refused.
  [[nodiscard]] std::unique_ptr<RawClient> OpenLive() const;
  [[nodiscard]] const RawTarget& target() const { return target_; }
  /// The same session, coming from elsewhere.
  [[nodiscard]] ConsoleBrowser From(RawTarget target) const;

 private:
  Answer Send(const std::string& request);
  [[nodiscard]] std::string Head() const;

  RawTarget target_;
  std::string cookie_;
  std::string csrf_;
};

/// Reads a WebSocket of the console in a thread of its own, and answers its pings.
class LiveListener {
 public:
  struct Heard {
    nlohmann::json message;
    std::chrono::nanoseconds time{0};  ///< SystemClock::Now() when it had come.
  };
  explicit LiveListener(std::unique_ptr<RawClient> socket);
  /// Ends the connection as a browser that dies does: with a reset.
  ~LiveListener();
  LiveListener(const LiveListener&) = delete;
  LiveListener& operator=(const LiveListener&) = delete;

  /// Waits for a message of this type, among all that have come; null if none comes.
  [[nodiscard]] nlohmann::json WaitFor(const std::string& type);
  /// Waits for the end of the connection; the close code, 0 without one, −1 if it did not end.
  [[nodiscard]] int WaitForEnd();
  [[nodiscard]] std::vector<Heard> All() const;

 private:
  void Listen(const std::stop_token& stop);

  std::unique_ptr<RawClient> socket_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Heard> heard_;
  std::optional<int> ended_;
  std::jthread thread_;  ///< Last: it ends first.
};

}  // namespace annulus::test
