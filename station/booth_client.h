#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "base/clock.h"
#include "base/result.h"
#include "sim/unix_socket.h"
#include "station/booth_messages.h"

namespace annulus {

/// A session with `annulus boothd` over its socket. Every wait has a deadline. Thread-bound.
class BoothClient {
 public:
  /// Connects, trying for as long as `within` while nobody listens, and says hello. Fails with boothd's reason if it
  /// does not want us.
  static Result<BoothClient> Connect(const std::string& path, const HelloOrder& hello, std::chrono::nanoseconds within);

  /// What boothd said of the booth.
  [[nodiscard]] const BoothDescription& booth() const { return welcome_.booth; }
  [[nodiscard]] bool controls() const { return welcome_.control; }
  /// The newest status that has come; there is one from the start.
  [[nodiscard]] const StatusMessage& status() const { return status_; }

  /// Sends an order and waits for its reply: boothd's error if it refused, ours if none comes. Other messages that come
  /// meanwhile are kept for Next.
  Status Ask(const BoothOrder& order, std::chrono::nanoseconds within);
  /// The next message that is no reply; nothing if none comes.
  Result<std::optional<BoothMessage>> Next(std::chrono::nanoseconds within);
  /// Reads messages, which are dropped, until the status is as wanted. Fails if it is not within the time.
  Status WaitFor(const std::function<bool(const StatusMessage&)>& wanted, std::chrono::nanoseconds within);

 private:
  explicit BoothClient(sim::OwnedFd fd) : fd_(std::move(fd)) {}
  Status Send(const BoothOrder& order, std::chrono::nanoseconds deadline);
  /// The next message, whatever it is; nothing if none comes. A goodbye, or the end of the connection, is an Error.
  Result<std::optional<BoothMessage>> Receive(std::chrono::nanoseconds deadline);

  SystemClock clock_;
  sim::OwnedFd fd_;
  BoothFrameReader frames_{kMaxBoothMessage};
  std::uint64_t last_id_ = 0;
  WelcomeMessage welcome_;
  StatusMessage status_;
  std::deque<BoothMessage> kept_;
};

}  // namespace annulus
