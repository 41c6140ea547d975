#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/socket_can_codec.h"

namespace annulus {

/// One end of a pair of sockets as a CAN bus, in real time and between threads: what a kernel without CAN can do.
class SocketPairCanBus final : public CanBus {
 public:
  /// Two buses that are one.
  static std::pair<std::unique_ptr<CanBus>, std::unique_ptr<CanBus>> Make(Clock& clock) {
    std::array<int, 2> ends{-1, -1};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) return {};
    return {std::make_unique<SocketPairCanBus>(ends[0], clock), std::make_unique<SocketPairCanBus>(ends[1], clock)};
  }
  SocketPairCanBus(int fd, Clock& clock) : fd_(fd), clock_(clock) {}
  ~SocketPairCanBus() override { close(fd_); }
  SocketPairCanBus(const SocketPairCanBus&) = delete;
  SocketPairCanBus& operator=(const SocketPairCanBus&) = delete;

  CanResult<CanLink> ReadLink() override { return CanLink{"pair", CanState::kErrorActive, true, {}, {}, {}, 128}; }
  CanResult<void> Send(const CanFrame& frame) override {
    const auto bytes = EncodeSocketCan(frame);
    if (send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size())) return {};
    return Fail(errno == EAGAIN ? CanFault::kQueueFull : CanFault::kGone);
  }
  CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) override {
    while (true) {
      std::array<std::byte, 72> bytes{};
      const ssize_t got = recv(fd_, bytes.data(), bytes.size(), 0);
      if (got == 0) return Fail(CanFault::kGone);
      if (got > 0) {
        auto what = DecodeSocketCan(std::span(bytes).first(static_cast<std::size_t>(got)));
        if (what) return std::optional(CanReception{clock_.Now(), std::move(*what)});
        continue;
      }
      const auto left = deadline - clock_.Now();
      if (left <= std::chrono::nanoseconds(0)) return std::optional<CanReception>();
      const timespec wait{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
      pollfd ready{fd_, POLLIN, 0};
      ppoll(&ready, 1, &wait, nullptr);
    }
  }
  [[nodiscard]] std::uint64_t overflows() const override { return 0; }
  CanResult<void> Reopen() override { return {}; }
  CanResult<void> Restart() override { return {}; }

 private:
  static tl::unexpected<CanFailure> Fail(CanFault fault) {
    return tl::unexpected<CanFailure>(CanFailure{fault, std::strerror(errno)});
  }

  int fd_;
  Clock& clock_;
};

}  // namespace annulus
