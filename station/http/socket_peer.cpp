#include "station/http/socket_peer.h"

#include <utility>

#include "station/http/http_target.h"

namespace annulus {
namespace {

/// RFC 6455 §5.5: a control frame has at most 125 bytes, of which the code takes two.
constexpr std::size_t kMaxReasonBytes = 123;

}  // namespace

void SocketPeer::Wake() {
  if (woken_) return;
  woken_ = true;
  wake_();
}

void SocketPeer::Send(Message message) {
  if (message.bytes == nullptr) return;
  const std::lock_guard lock(mutex_);
  if (state_ == State::kEnded || goodbye_ || overflowed_) return;
  if (queued_ + message.bytes->size() > max_bytes_) {
    overflowed_ = true;
    for (const Message& dropped : messages_) queued_ -= dropped.bytes->size();
    messages_.clear();
  } else {
    queued_ += message.bytes->size();
    messages_.push_back(std::move(message));
  }
  Wake();
}

void SocketPeer::Close(std::uint16_t code, std::string reason) {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kEnded || goodbye_) return;
  while (reason.size() > kMaxReasonBytes || (!reason.empty() && !IsPlainUtf8(reason))) reason.pop_back();
  goodbye_ = Goodbye{code, std::move(reason)};
  Wake();
}

bool SocketPeer::MarkOpen() {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kEnded) return false;
  state_ = State::kOpen;
  return true;
}

SocketPeer::State SocketPeer::MarkEnded() {
  std::deque<Message> dropped;
  const std::lock_guard lock(mutex_);
  const State before = state_;
  state_ = State::kEnded;
  wake_ = nullptr;
  dropped.swap(messages_);
  queued_ = 0;
  return before;
}

bool SocketPeer::TakeWake() {
  const std::lock_guard lock(mutex_);
  woken_ = false;
  return overflowed_;
}

SocketPeer::Next SocketPeer::Take() {
  const std::lock_guard lock(mutex_);
  if (messages_.empty()) return {std::nullopt, goodbye_};
  Next next{std::move(messages_.front()), std::nullopt};
  messages_.pop_front();
  return next;
}

}  // namespace annulus
