#include "tests/hil/guest/raw_can.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace annulus::hil {

RawCan::RawCan(const std::string& interface) : socket_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
  EXPECT_GE(socket_, 0) << std::strerror(errno);
  const int on = 1;
  EXPECT_EQ(::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on), 0);
  const int room = 4 << 20;  // bytes; the kernel's default holds some 270 frames
  EXPECT_EQ(::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room), 0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << interface;
}

RawCan::~RawCan() { ::close(socket_); }

void RawCan::Send(const canfd_frame& frame, bool fd) const {
  const std::size_t size = fd ? CANFD_MTU : CAN_MTU;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (::write(socket_, &frame, size) != static_cast<ssize_t>(size)) {
    const bool full = errno == ENOBUFS || errno == EAGAIN;
    if (!full || std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "write a raw CAN frame: " << std::strerror(errno);
      return;
    }
    ::usleep(200);
  }
}

void RawCan::SendError(canid_t classes, const unsigned char (&data)[8]) const {
  canfd_frame frame{};
  frame.can_id = CAN_ERR_FLAG | classes;
  frame.len = CAN_ERR_DLC;
  std::memcpy(frame.data, data, sizeof data);
  Send(frame);
}

std::optional<canfd_frame> RawCan::Receive(std::chrono::milliseconds patience) const {
  pollfd wait{socket_, POLLIN, 0};
  if (::poll(&wait, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
  canfd_frame frame{};
  if (::read(socket_, &frame, sizeof frame) < static_cast<ssize_t>(CAN_MTU)) return std::nullopt;
  return frame;
}

}  // namespace annulus::hil
