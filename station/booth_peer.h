#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "sim/unix_socket.h"
#include "station/booth_messages.h"
#include "station/booth_server.h"
#include "station/booth_socket.h"

namespace annulus {

/// So many requests a second, with bursts.
class RequestBudget {
 public:
  explicit RequestBudget(std::chrono::nanoseconds now) : filled_(now) {}
  /// Whether there is one left; takes it.
  bool Take(std::chrono::nanoseconds now);
  /// Refused since the last time that the budget was whole.
  [[nodiscard]] int refused() const { return refused_; }

 private:
  double left_ = booth_limit::kBurst;
  std::chrono::nanoseconds filled_;
  int refused_ = 0;
};

/// One client of the booth's server: its connection and what it is allowed. Never waits. Thread-bound.
class BoothPeer {
 public:
  BoothPeer(BoothSocket::Connection connection, std::chrono::nanoseconds now);
  BoothPeer(const BoothPeer&) = delete;
  BoothPeer& operator=(const BoothPeer&) = delete;
  /// What it has sent and nobody has read is thrown away first: the kernel would otherwise break the connection off,
  /// and with it our last words.
  ~BoothPeer();

  /// Reads what has come, up to a limit, so that everybody has his turn.
  void Receive();
  /// The next request that has come whole, as JSON; an overlong frame ends the connection with a goodbye.
  std::optional<std::string> NextRequest();
  /// Puts a message, or one that was encoded before, into the queue. A queue that gets too long ends the connection.
  void Send(const BoothMessage& message) { SendText(EncodeMessage(message)); }
  void SendText(const std::string& text);
  /// Writes as much of the queue as the connection takes.
  void Flush();
  /// Says why, and ends the connection once that is written; at once if it does not take it.
  void End(const std::string& reason);

  [[nodiscard]] int fd() const { return fd_.get(); }
  /// By us, or by the client; of the latter the requests before are still to be taken.
  [[nodiscard]] bool ended() const { return ended_ || gone_; }
  /// Ended, and nothing more of it reaches the client: told all, or not listening, or not reading for kLastWords.
  [[nodiscard]] bool finished(std::chrono::nanoseconds now);
  [[nodiscard]] bool waits_to_write() const { return !queue_.empty(); }
  [[nodiscard]] const PeerCredentials& credentials() const { return credentials_; }

  // What it is allowed; kept by the server.
  std::optional<HelloOrder> hello;
  bool controls = false;
  bool has_jogged = false;
  SubscribeOrder previews{0, 1};
  static constexpr std::chrono::seconds kLastWords{1};
  RequestBudget budget;
  std::chrono::nanoseconds since;  ///< It connected.

 private:
  sim::OwnedFd fd_;
  PeerCredentials credentials_;
  BoothFrameReader frames_{kMaxBoothRequest};
  std::string queue_;
  std::optional<std::chrono::nanoseconds> ending_since_;  ///< Seen by finished().
  bool ended_ = false;                                    ///< By us.
  bool gone_ = false;  ///< The client has closed it, and everything that it sent has been read.
  bool deaf_ = false;  ///< It takes nothing more.
};

}  // namespace annulus
