#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/console_whole/console_browser.h"

namespace annulus::test {

/// Browsers that are connected to /api/live and never read (fault row N4), from addresses 127.0.5.x; half of them are
/// logged in, with the session of `browser`.
class StuckClients {
 public:
  StuckClients(const ConsoleBrowser& browser, std::size_t count);
  /// How many connections the server still has with them: as the system's table of connections says, since to ask them
  /// would be to read.
  [[nodiscard]] std::size_t StillServed() const;

 private:
  std::uint16_t port_;
  std::vector<std::unique_ptr<RawClient>> sockets_;
};

/// What fault row N5 does to a console: 1,200 bad requests a second, from threads that make up for what they were late.
///
///     600 /s   over TLS, kept alive, from eight addresses: without a session, without a token, of a foreign Origin,
///              a wrong password now and then
///     200 /s   over TLS, a connection each, from four addresses: no HTTP
///     400 /s   no TLS, from one address
///     32       connections that send a byte of a head every quarter of a second (slowloris), beside
class BadClients {
 public:
  explicit BadClients(const RawTarget& target);
  /// Ends them.
  ~BadClients() = default;
  BadClients(const BadClients&) = delete;
  BadClients& operator=(const BadClients&) = delete;

  /// Requests sent since the start, for each second of it.
  [[nodiscard]] double PerSecond() const;
  /// "600 unauthenticated/s, …".
  [[nodiscard]] std::string Text() const;

 private:
  enum Kind : std::size_t { kUnauthenticated, kNoHttp, kNoTls, kSlow, kKinds };

  void SendUnauthenticated(const std::stop_token& stop);
  void SendNoHttp(const std::stop_token& stop);
  void SendNoTls(const std::stop_token& stop);
  void SendSlowly(const std::stop_token& stop);
  [[nodiscard]] double Seconds() const;
  /// Waits until one more of this kind is due; false if it is to end.
  bool NextOf(Kind kind, double per_second, const std::stop_token& stop);
  [[nodiscard]] RawTarget From(const std::string& address) const;

  const RawTarget target_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::array<std::atomic<int>, kKinds> sent_{};
  std::vector<std::jthread> threads_;  ///< Last: they end first.
};

}  // namespace annulus::test
