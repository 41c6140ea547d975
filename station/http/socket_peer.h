#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "station/http/http_server.h"

namespace annulus {

/// What a handler holds of a WebSocket: the messages that wait, between any threads and the io thread.
///
///     opening --MarkOpen--> open --MarkEnded--> ended      (opening --MarkEnded--> ended: refused, or gone meanwhile)
///
/// Thread-safe.
class SocketPeer final : public WebSocketPeer {
 public:
  enum class State { kOpening, kOpen, kEnded };
  struct Message {
    std::shared_ptr<const std::string> bytes;
    bool binary = false;
  };
  struct Goodbye {
    std::uint16_t code = 0;
    std::string reason;
  };

  /// `wake` is called when there is something to do for the io thread, never after MarkEnded; it must not call back.
  SocketPeer(std::size_t max_bytes, std::function<void()> wake) : max_bytes_(max_bytes), wake_(std::move(wake)) {}

  void SendText(std::shared_ptr<const std::string> text) override { Send({std::move(text), false}); }
  void SendBinary(std::shared_ptr<const std::string> bytes) override { Send({std::move(bytes), true}); }
  [[nodiscard]] std::size_t queued_bytes() const override { return queued_.load(); }
  void Close(std::uint16_t code, std::string reason) override;

  /// False if it has ended meanwhile.
  bool MarkOpen();
  /// Drops all that waits; nothing is taken any more. The state that it was in.
  State MarkEnded();

  /// The io thread has been woken, and will be again. True if the client has left too much unread: it is to be cut off.
  [[nodiscard]] bool TakeWake();
  /// What is to be sent next: a message, else a goodbye, else nothing.
  struct Next {
    std::optional<Message> message;
    std::optional<Goodbye> goodbye;
  };
  [[nodiscard]] Next Take();
  /// The message that Take gave has been sent.
  void Sent(const Message& message) { queued_ -= message.bytes->size(); }

 private:
  void Send(Message message);
  void Wake();

  const std::size_t max_bytes_;
  std::atomic<std::size_t> queued_{0};
  std::mutex mutex_;
  State state_ = State::kOpening;
  std::function<void()> wake_;
  bool woken_ = false;
  bool overflowed_ = false;
  std::deque<Message> messages_;
  std::optional<Goodbye> goodbye_;
};

}  // namespace annulus
