#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware_iface/can_bus.h"
#include "firmware_iface/can_netlink.h"
#include "firmware_iface/socket_can_codec.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Room for about 0.2 s of a full bus while the host is away; the kernel counts some 500 bytes of overhead per frame.
constexpr int kReceiveBufferBytes = 4 << 20;
/// Longest single poll, so that a clock that is not the kernel's cannot make a wait without end.
constexpr nanoseconds kLongestPoll = std::chrono::milliseconds(100);

tl::unexpected<CanFailure> FailErrno(int error) {
  CanFault fault = CanFault::kError;
  if (error == ENOBUFS || error == EAGAIN) fault = CanFault::kQueueFull;
  if (error == ENETDOWN) fault = CanFault::kDown;
  if (error == ENODEV || error == ENXIO) fault = CanFault::kGone;
  return tl::unexpected<CanFailure>(CanFailure{fault, std::strerror(error)});
}

nanoseconds WallNow() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::chrono::seconds(now.tv_sec) + nanoseconds(now.tv_nsec);
}

/// An open socket, bound to one interface.
class CanSocket {
 public:
  CanSocket() = default;
  explicit CanSocket(int fd) : fd_(fd) {}
  ~CanSocket() {
    if (fd_ >= 0) close(fd_);
  }
  CanSocket(CanSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  CanSocket& operator=(CanSocket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  CanSocket(const CanSocket&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_ = -1;
};

template <class Value>
bool Set(const CanSocket& socket, int level, int option, const Value& value) {
  return setsockopt(socket.fd(), level, option, &value, sizeof(value)) == 0;
}

/// Binds a socket to an interface, with all that the seam promises: error frames, FD, time stamps, loss counter.
CanResult<CanSocket> BindTo(const std::string& name) {
  CanSocket bound(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (bound.fd() < 0) return FailErrno(errno);
  ifreq request{};
  name.copy(request.ifr_name, sizeof(request.ifr_name) - 1);
  if (ioctl(bound.fd(), SIOCGIFINDEX, &request) < 0) return FailErrno(errno);
  const int index = request.ifr_ifindex;
  if (ioctl(bound.fd(), SIOCGIFFLAGS, &request) < 0) return FailErrno(errno);
  if ((request.ifr_flags & IFF_UP) == 0) return FailErrno(ENETDOWN);
  if (ioctl(bound.fd(), SIOCGIFMTU, &request) < 0) return FailErrno(errno);
  const int fd_frames = request.ifr_mtu >= static_cast<int>(CANFD_MTU) ? 1 : 0;
  const can_err_mask_t errors = CAN_ERR_MASK;
  const int on = 1;
  if (!Set(bound, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors) ||
      (fd_frames == 1 && !Set(bound, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, fd_frames)) ||
      !Set(bound, SOL_SOCKET, SO_RXQ_OVFL, on) || !Set(bound, SOL_SOCKET, SO_TIMESTAMPNS, on)) {
    return FailErrno(errno);
  }
  // Only the privileged may go beyond the system's limit; what the system grants is enough for a host that is not late.
  if (!Set(bound, SOL_SOCKET, SO_RCVBUFFORCE, kReceiveBufferBytes)) {
    static_cast<void>(Set(bound, SOL_SOCKET, SO_RCVBUF, kReceiveBufferBytes));
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (bind(bound.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) < 0) return FailErrno(errno);
  return bound;
}

class SocketCanBus final : public CanBus {
 public:
  /// `bound` is when the socket was bound.
  SocketCanBus(std::string name, CanSocket socket, nanoseconds bound, Clock& clock)
      : name_(std::move(name)), socket_(std::move(socket)), clock_(clock), empty_since_(bound) {}

  CanResult<CanLink> ReadLink() override { return ReadCanLink(name_); }
  CanResult<void> Restart() override { return RestartCanLink(name_); }
  CanResult<void> Send(const CanFrame& frame) override;
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t overflows() const override { return lost_before_ + lost_; }
  CanResult<void> Reopen() override;

 private:
  CanResult<std::optional<CanReception>> Collect();
  tl::unexpected<CanFailure> FailReading(int error);
  void CountLost(std::uint32_t total);
  [[nodiscard]] nanoseconds ArrivalBy(nanoseconds stamp) const;

  std::string name_;
  CanSocket socket_;
  Clock& clock_;
  nanoseconds empty_since_;        ///< When the socket was last known to hold nothing.
  std::uint64_t lost_before_ = 0;  ///< Of sockets before this one.
  std::uint64_t lost_ = 0;         ///< Of this socket; the kernel's counter has 32 bits.
};

CanResult<void> SocketCanBus::Send(const CanFrame& frame) {
  if (socket_.fd() < 0) return FailErrno(ENODEV);
  const auto bytes = EncodeSocketCan(frame);
  while (true) {
    const ssize_t sent = write(socket_.fd(), bytes.data(), bytes.size());
    if (sent == static_cast<ssize_t>(bytes.size())) return {};
    if (sent < 0 && errno == EINTR) continue;
    return FailErrno(sent < 0 ? errno : EIO);
  }
}

CanResult<std::optional<CanReception>> SocketCanBus::Receive(nanoseconds deadline) {
  if (socket_.fd() < 0) return FailErrno(ENODEV);
  while (true) {
    auto collected = Collect();
    if (!collected || *collected) return collected;
    const nanoseconds left = deadline - clock_.Now();
    if (left <= nanoseconds(0)) return std::optional<CanReception>();
    const auto step = std::min(left, kLongestPoll);
    const timespec wait{0, static_cast<long>(step.count())};
    pollfd waiting{socket_.fd(), POLLIN, 0};
    if (ppoll(&waiting, 1, &wait, nullptr) < 0 && errno != EINTR) return FailErrno(errno);
  }
}

/// One read of the socket, skipping what is neither frame nor report.
CanResult<std::optional<CanReception>> SocketCanBus::Collect() {
  while (true) {
    std::array<std::byte, CANFD_MTU> bytes{};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(__u32))> control{};
    iovec vector{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &vector;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const nanoseconds asked = clock_.Now();
    const ssize_t got = recvmsg(socket_.fd(), &message, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) {
      empty_since_ = asked;
      return std::optional<CanReception>();
    }
    if (got < 0) return FailReading(errno);
    CanReception reception;
    reception.host_time = clock_.Now();
    for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
         part = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(part))) {
      if (part->cmsg_level != SOL_SOCKET) continue;
      if (part->cmsg_type == SO_RXQ_OVFL) {
        std::uint32_t total = 0;
        std::memcpy(&total, CMSG_DATA(part), sizeof(total));
        CountLost(total);
      } else if (part->cmsg_type == SCM_TIMESTAMPNS) {
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(part), sizeof(stamp));
        reception.host_time = ArrivalBy(std::chrono::seconds(stamp.tv_sec) + nanoseconds(stamp.tv_nsec));
      }
    }
    auto what = DecodeSocketCan(std::span(bytes).first(static_cast<std::size_t>(got)));
    if (!what) continue;
    reception.what = *what;
    return std::optional<CanReception>(reception);
  }
}

/// The kernel tells only once that an interface is no more, and lets a reader wait for ever after.
tl::unexpected<CanFailure> SocketCanBus::FailReading(int error) {
  if (error == ENODEV || error == ENXIO) socket_ = CanSocket();
  return FailErrno(error);
}

/// The kernel's total of this socket, 32 bits.
void SocketCanBus::CountLost(std::uint32_t total) { lost_ += static_cast<std::uint32_t>(total - lost_); }

/// The kernel stamps by the wall clock.
nanoseconds SocketCanBus::ArrivalBy(nanoseconds stamp) const {
  SocketCanTimes times;
  times.stamp = stamp;
  times.wall_now = WallNow();
  times.now = clock_.Now();
  times.empty_since = empty_since_;
  return ArrivalOf(times);
}

CanResult<void> SocketCanBus::Reopen() {
  socket_ = CanSocket();
  empty_since_ = clock_.Now();
  lost_before_ += std::exchange(lost_, 0);
  auto bound = BindTo(name_);
  if (!bound) return tl::unexpected<CanFailure>(bound.error());
  socket_ = std::move(*bound);
  return {};
}

std::string AdviceFor(const std::string& name, const CanFailure& failure) {
  if (failure.fault == CanFault::kDown) {
    return "bring it up: ip link set " + name + " up type can bitrate 1000000 restart-ms 1000";
  }
  if (failure.fault == CanFault::kGone) return "check can of [ring] and the adapter; `ip link` lists what is there";
  return "check the adapter and the rights of this user";
}

}  // namespace

Result<std::unique_ptr<CanBus>> OpenSocketCan(const std::string& name, Clock& clock) {
  const std::string attempted = "open CAN interface " + name;
  if (name.empty() || name.size() >= IFNAMSIZ) {
    return Fail(attempted, "no interface has such a name", "correct can of [ring]");
  }
  const nanoseconds before = clock.Now();
  auto bound = BindTo(name);
  if (bound) return std::make_unique<SocketCanBus>(name, std::move(*bound), before, clock);
  const std::string seen = CanFailureText(bound.error());
  if (CanSocket probe(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)); probe.fd() < 0) {
    return Fail(attempted, "this kernel has no CAN (" + bound.error().detail + ")",
                "load the modules can and can_raw and the adapter's driver, or use a kernel that has them");
  }
  return Fail(attempted, seen, AdviceFor(name, bound.error()));
}

Result<std::vector<CanLink>> ListCanInterfaces() {
  if (CanSocket probe(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)); probe.fd() < 0) return std::vector<CanLink>();
  auto links = ReadCanLinks();
  if (!links) {
    return Fail("list the CAN interfaces", CanFailureText(links.error()), "check the rights of this user");
  }
  return std::move(*links);
}

}  // namespace annulus
