#include "station/booth_client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <variant>

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr const char* kAttempted = "talk to boothd";
constexpr std::size_t kMaxKept = 4096;

/// Waits until the connection can be read, or written; false: not in time.
bool WaitReady(int fd, short events, nanoseconds left) {
  pollfd ready{fd, events, 0};
  const auto wait = std::chrono::ceil<milliseconds>(left).count();
  return ::poll(&ready, 1, static_cast<int>(std::clamp<std::int64_t>(wait, 0, 3'600'000))) > 0;
}

tl::unexpected<Error> ConnectionLost(const std::string& seen) {
  return Fail(kAttempted, seen, "see whether boothd runs, and what it says");
}

}  // namespace

Result<BoothClient> BoothClient::Connect(const std::string& path, const HelloOrder& hello, nanoseconds within) {
  const nanoseconds deadline = SystemClock().Now() + within;
  auto fd = sim::ConnectUnixSocket(path, deadline);
  if (!fd) {
    return Fail(fd.error().attempted, fd.error().seen, "start 'annulus boothd', or say where it listens with --socket");
  }
  BoothClient client(std::move(*fd));
  RETURN_IF_ERROR(client.Send(hello, deadline));
  bool welcome = false;
  while (true) {
    const auto message = client.Receive(deadline);
    if (!message) return Fail(message);
    if (!*message) return ConnectionLost("no welcome came");
    if (const auto* reply = std::get_if<ReplyMessage>(&**message); reply != nullptr && !reply->result) {
      return Fail(reply->result);
    }
    if (const auto* came = std::get_if<WelcomeMessage>(&**message)) {
      client.welcome_ = *came;
      welcome = true;
    }
    if (welcome && std::holds_alternative<StatusMessage>(**message)) return client;
  }
}

Status BoothClient::Send(const BoothOrder& order, nanoseconds deadline) {
  const auto frame = BoothFrame(EncodeRequest({++last_id_, order}));
  if (!frame) return Fail(kAttempted, "the request is too long", "give shorter texts");
  std::size_t written = 0;
  while (written < frame->size()) {
    const ssize_t sent =
        ::send(fd_.get(), frame->data() + written, frame->size() - written, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      written += static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!WaitReady(fd_.get(), POLLOUT, deadline - clock_.Now())) return ConnectionLost("it takes no requests");
    } else if (errno != EINTR) {
      return ConnectionLost(std::strerror(errno));
    }
  }
  return {};
}

Result<std::optional<BoothMessage>> BoothClient::Receive(nanoseconds deadline) {
  while (true) {
    const auto text = frames_.Next();
    if (!text) return Fail(text);
    if (*text) {
      auto message = DecodeMessage(**text);
      if (!message) return Fail(message);
      if (const auto* bye = std::get_if<ByeMessage>(&*message)) return ConnectionLost(bye->reason);
      if (const auto* status = std::get_if<StatusMessage>(&*message)) status_ = *status;
      return std::optional(std::move(*message));
    }
    if (!WaitReady(fd_.get(), POLLIN, deadline - clock_.Now())) return std::optional<BoothMessage>();
    std::array<char, 16'384> bytes;
    const ssize_t got = ::recv(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got > 0) {
      frames_.Append({bytes.data(), static_cast<std::size_t>(got)});
    } else if (got == 0) {
      return ConnectionLost("it closed the connection");
    } else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
      return ConnectionLost(std::strerror(errno));
    }
  }
}

Status BoothClient::Ask(const BoothOrder& order, nanoseconds within) {
  const nanoseconds deadline = clock_.Now() + within;
  RETURN_IF_ERROR(Send(order, deadline));
  while (true) {
    auto message = Receive(deadline);
    if (!message) return Fail(message);
    if (!*message) return ConnectionLost("no reply came");
    if (const auto* reply = std::get_if<ReplyMessage>(&**message)) {
      if (reply->id == last_id_) return reply->result;
    } else if (kept_.size() < kMaxKept) {
      kept_.push_back(std::move(**message));
    }
  }
}

Result<std::optional<BoothMessage>> BoothClient::Next(nanoseconds within) {
  if (!kept_.empty()) {
    std::optional<BoothMessage> first(std::move(kept_.front()));
    kept_.pop_front();
    return first;
  }
  const nanoseconds deadline = clock_.Now() + within;
  while (true) {
    auto message = Receive(deadline);
    // The reply to an order whose time was over.
    if (message && *message && std::holds_alternative<ReplyMessage>(**message)) continue;
    return message;
  }
}

Status BoothClient::WaitFor(const std::function<bool(const StatusMessage&)>& wanted, nanoseconds within) {
  const nanoseconds deadline = clock_.Now() + within;
  kept_.clear();
  while (!wanted(status_)) {
    const auto message = Receive(deadline);
    if (!message) return Fail(message);
    if (!*message) {
      return Fail("wait for the booth", std::string("it is ") + ScanStateText(status_.scanner.state) + " still",
                  "look at its status");
    }
  }
  return {};
}

}  // namespace annulus
