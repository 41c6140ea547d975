#include "station/booth_peer.h"

#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "base/log.h"

namespace annulus {
namespace {

constexpr std::size_t kReadBytes = std::size_t{16} << 10;

}  // namespace

bool RequestBudget::Take(std::chrono::nanoseconds now) {
  const double passed = std::chrono::duration<double>(now - filled_).count();
  filled_ = now;
  left_ = std::min(booth_limit::kBurst, left_ + passed * booth_limit::kRequestsPerSecond);
  if (left_ == booth_limit::kBurst) refused_ = 0;
  if (left_ < 1.0) {
    ++refused_;
    return false;
  }
  left_ -= 1.0;
  return true;
}

BoothPeer::BoothPeer(BoothSocket::Connection connection, std::chrono::nanoseconds now)
    : budget(now), since(now), fd_(std::move(connection.fd)), credentials_(std::move(connection.peer)) {}

void BoothPeer::Receive() {
  std::array<char, kReadBytes> bytes;
  const ssize_t got = ::recv(fd_.get(), bytes.data(), bytes.size(), 0);
  if (got > 0 && ended_) return;  // thrown away: only our last words are still on their way
  if (got > 0) {
    frames_.Append({bytes.data(), static_cast<std::size_t>(got)});
  } else if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
    gone_ = true;
  }
}

std::optional<std::string> BoothPeer::NextRequest() {
  if (ended_) return std::nullopt;
  auto text = frames_.Next();
  if (text) return std::move(*text);
  End(text.error().Text());
  return std::nullopt;
}

void BoothPeer::SendText(const std::string& text) {
  if (ended_ || deaf_) return;
  const auto frame = BoothFrame(text);
  if (!frame) {
    Log(LogLevel::kError, "booth socket: a message of " + std::to_string(text.size()) + " bytes was not sent");
    return;
  }
  queue_.append(*frame);
  Flush();
  if (queue_.size() > booth_limit::kQueueBytes) {
    Log(LogLevel::kWarning, "booth socket: process " + std::to_string(credentials_.pid) + " does not read: dropped");
    ended_ = deaf_ = true;
  }
}

void BoothPeer::Flush() {
  std::size_t written = 0;
  while (written < queue_.size() && !deaf_) {
    const ssize_t sent = ::send(fd_.get(), queue_.data() + written, queue_.size() - written, MSG_NOSIGNAL);
    if (sent > 0) {
      written += static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      break;
    } else if (errno != EINTR) {
      deaf_ = true;  // what it sent before it closed is still read: there may be a cancel among it
    }
  }
  queue_.erase(0, deaf_ ? queue_.size() : written);
}

bool BoothPeer::finished(std::chrono::nanoseconds now) {
  if (!ended()) return false;
  if (gone_ || deaf_ || queue_.empty()) return true;
  if (!ending_since_) ending_since_ = now;
  return now - *ending_since_ >= kLastWords;
}

BoothPeer::~BoothPeer() {
  if (fd_.get() < 0) return;
  ::shutdown(fd_.get(), SHUT_RD);
  char rest[4096];
  while (::recv(fd_.get(), rest, sizeof rest, MSG_DONTWAIT) > 0) {
  }
}

void BoothPeer::End(const std::string& reason) {
  Send(ByeMessage{reason});
  ended_ = true;
}

}  // namespace annulus
