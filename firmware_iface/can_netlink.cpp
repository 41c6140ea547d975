#include "firmware_iface/can_netlink.h"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

namespace annulus {
namespace {

constexpr std::size_t kReplyBytes =
    65536;  ///< A message of an interface is below 4 KiB; a dump comes in several reads.
constexpr timeval kTimeout{1, 0};
/// ARPHRD_CAN of linux/if_arp.h, which cannot stand beside net/if.h.
constexpr unsigned short kCanHardware = 280;

tl::unexpected<CanFailure> FailWith(CanFault fault, std::string detail) {
  return tl::unexpected<CanFailure>(CanFailure{fault, std::move(detail)});
}

tl::unexpected<CanFailure> FailErrno(int error) {
  const bool gone = error == ENODEV || error == ENXIO;
  return FailWith(gone ? CanFault::kGone : CanFault::kError, std::strerror(error));
}

/// An open rtnetlink socket.
class RouteSocket {
 public:
  explicit RouteSocket(int fd) : fd_(fd) {}
  ~RouteSocket() {
    if (fd_ >= 0) close(fd_);
  }
  RouteSocket(RouteSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  RouteSocket(const RouteSocket&) = delete;
  RouteSocket& operator=(const RouteSocket&) = delete;

  static CanResult<RouteSocket> Open() {
    RouteSocket route(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
    if (route.fd_ < 0) return FailErrno(errno);
    if (setsockopt(route.fd_, SOL_SOCKET, SO_RCVTIMEO, &kTimeout, sizeof(kTimeout)) < 0 ||
        setsockopt(route.fd_, SOL_SOCKET, SO_SNDTIMEO, &kTimeout, sizeof(kTimeout)) < 0) {
      return FailErrno(errno);
    }
    return route;
  }
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

/// A request under construction; room for one interface and a few attributes.
struct Request {
  nlmsghdr header{};
  ifinfomsg link{};
  std::array<char, 256> attributes{};
};

/// Appends an attribute; returns its offset, by which one that nests can be closed.
std::size_t Append(Request& request, unsigned short type, const void* data, std::size_t size) {
  const std::size_t at = NLMSG_ALIGN(request.header.nlmsg_len);
  auto* bytes = reinterpret_cast<char*>(&request);
  const rtattr attribute{static_cast<unsigned short>(RTA_LENGTH(size)), type};
  std::memcpy(bytes + at, &attribute, sizeof(attribute));
  if (size > 0) std::memcpy(bytes + at + RTA_LENGTH(0), data, size);
  request.header.nlmsg_len = static_cast<__u32>(at + RTA_ALIGN(attribute.rta_len));
  return at;
}

void CloseNest(Request& request, std::size_t at) {
  const auto length = static_cast<unsigned short>(request.header.nlmsg_len - at);
  std::memcpy(reinterpret_cast<char*>(&request) + at, &length, sizeof(length));
}

Request NewRequest(unsigned short type, unsigned short flags) {
  Request request;
  request.header.nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
  request.header.nlmsg_type = type;
  request.header.nlmsg_flags = static_cast<__u16>(NLM_F_REQUEST | flags);
  request.header.nlmsg_seq = 1;
  request.link.ifi_family = AF_UNSPEC;
  return request;
}

std::optional<std::uint32_t> NumberOf(const rtattr* attribute) {
  if (RTA_PAYLOAD(attribute) < sizeof(std::uint32_t)) return std::nullopt;
  std::uint32_t value = 0;
  std::memcpy(&value, RTA_DATA(attribute), sizeof(value));
  return value;
}

/// The attributes in a run of bytes; f(type, attribute) for each that is whole.
template <class Function>
void ForEachAttribute(const rtattr* attribute, std::size_t bytes, Function f) {
  auto left = static_cast<int>(bytes);
  for (; RTA_OK(attribute, left); attribute = RTA_NEXT(attribute, left)) {
    f(attribute->rta_type & NLA_TYPE_MASK, attribute);
  }
}

CanState StateOf(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE:
      return CanState::kErrorActive;
    case CAN_STATE_ERROR_WARNING:
      return CanState::kErrorWarning;
    case CAN_STATE_ERROR_PASSIVE:
      return CanState::kErrorPassive;
    case CAN_STATE_BUS_OFF:
      return CanState::kBusOff;
    default:
      return CanState::kDown;
  }
}

std::optional<std::uint32_t> BitRateOf(const rtattr* attribute) {
  const auto rate = NumberOf(attribute);  // can_bittiming begins with it
  return rate && *rate != 0 ? rate : std::nullopt;
}

void ReadController(const rtattr* data, CanLink& link) {
  ForEachAttribute(static_cast<const rtattr*>(RTA_DATA(data)), RTA_PAYLOAD(data), [&](int type, const rtattr* one) {
    if (type == IFLA_CAN_BITTIMING) link.bit_rate = BitRateOf(one);
    if (type == IFLA_CAN_DATA_BITTIMING) link.data_bit_rate = BitRateOf(one);
    if (type == IFLA_CAN_RESTART_MS) link.restart_ms = NumberOf(one);
    if (type == IFLA_CAN_STATE) link.state = StateOf(NumberOf(one).value_or(CAN_STATE_MAX));
  });
}

/// What one message says, if it is of a CAN interface.
std::optional<CanLink> LinkOf(const nlmsghdr* message) {
  if (message->nlmsg_len < NLMSG_LENGTH(sizeof(ifinfomsg))) return std::nullopt;
  const auto* info = static_cast<const ifinfomsg*>(NLMSG_DATA(message));
  if (info->ifi_type != kCanHardware) return std::nullopt;
  CanLink link;
  link.state = CanState::kErrorActive;
  ForEachAttribute(IFLA_RTA(info), IFLA_PAYLOAD(message), [&](int type, const rtattr* one) {
    if (type == IFLA_IFNAME && RTA_PAYLOAD(one) > 0) {
      const auto* name = static_cast<const char*>(RTA_DATA(one));
      link.name.assign(name, strnlen(name, RTA_PAYLOAD(one)));
    }
    if (type == IFLA_MTU) link.fd = NumberOf(one).value_or(0) >= CANFD_MTU;
    if (type == IFLA_TXQLEN) link.queue_length = NumberOf(one).value_or(0);
    if (type != IFLA_LINKINFO) return;
    ForEachAttribute(static_cast<const rtattr*>(RTA_DATA(one)), RTA_PAYLOAD(one), [&](int inner, const rtattr* part) {
      if (inner == IFLA_INFO_DATA) ReadController(part, link);
    });
  });
  if ((info->ifi_flags & IFF_UP) == 0) link.state = CanState::kDown;
  return link;
}

/// A dump that broke off says so in its last message.
CanResult<void> EndOfDump(const nlmsghdr* done) {
  int error = 0;
  if (done->nlmsg_len >= NLMSG_LENGTH(sizeof(error))) std::memcpy(&error, NLMSG_DATA(done), sizeof(error));
  if (error < 0) return FailErrno(-error);
  return {};
}

/// Sends a request and gives each message of the answer to `f` until the answer ends.
template <class Function>
CanResult<void> Ask(Request& request, bool dump, Function f) {
  const auto route = RouteSocket::Open();
  if (!route) return tl::unexpected<CanFailure>(route.error());
  if (send(route->fd(), &request, request.header.nlmsg_len, 0) < 0) return FailErrno(errno);
  std::vector<char> buffer(kReplyBytes);
  while (true) {
    const ssize_t got = recv(route->fd(), buffer.data(), buffer.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return FailErrno(errno);
    // Rounded up as the steps are, or the count would wrap after a last message that does not end on a boundary.
    auto left = NLMSG_ALIGN(static_cast<unsigned>(got));
    const auto* message = reinterpret_cast<const nlmsghdr*>(buffer.data());
    for (; NLMSG_OK(message, left); message = NLMSG_NEXT(message, left)) {
      if (message->nlmsg_type == NLMSG_DONE) return EndOfDump(message);
      if (message->nlmsg_type == NLMSG_ERROR) {
        const int error = -static_cast<const nlmsgerr*>(NLMSG_DATA(message))->error;
        if (error != 0) return FailErrno(error);
        return {};
      }
      f(message);
      if (!dump) return {};
    }
    if (got == 0) return FailWith(CanFault::kError, "the kernel closed the netlink socket");
  }
}

CanResult<int> IndexOf(const std::string& name) {
  if (name.empty() || name.size() >= IF_NAMESIZE) return FailWith(CanFault::kGone, "no interface has this name");
  const unsigned index = if_nametoindex(name.c_str());
  if (index == 0) return FailErrno(errno);
  return static_cast<int>(index);
}

}  // namespace

CanResult<CanLink> ReadCanLink(const std::string& name) {
  const auto index = IndexOf(name);
  if (!index) return tl::unexpected<CanFailure>(index.error());
  Request request = NewRequest(RTM_GETLINK, 0);
  request.link.ifi_index = *index;
  std::optional<CanLink> link;
  const auto asked = Ask(request, false, [&](const nlmsghdr* message) { link = LinkOf(message); });
  if (!asked) return tl::unexpected<CanFailure>(asked.error());
  if (!link) return FailWith(CanFault::kGone, name + " is no CAN interface");
  return *link;
}

CanResult<std::vector<CanLink>> ReadCanLinks() {
  Request request = NewRequest(RTM_GETLINK, NLM_F_DUMP);
  std::vector<CanLink> links;
  const auto asked = Ask(request, true, [&](const nlmsghdr* message) {
    if (auto link = LinkOf(message)) links.push_back(std::move(*link));
  });
  if (!asked) return tl::unexpected<CanFailure>(asked.error());
  return links;
}

CanResult<void> RestartCanLink(const std::string& name) {
  const auto index = IndexOf(name);
  if (!index) return tl::unexpected<CanFailure>(index.error());
  Request request = NewRequest(RTM_NEWLINK, NLM_F_ACK);
  request.link.ifi_index = *index;
  const std::size_t info = Append(request, IFLA_LINKINFO, nullptr, 0);
  Append(request, IFLA_INFO_KIND, "can", 3);
  const std::size_t data = Append(request, IFLA_INFO_DATA, nullptr, 0);
  const std::uint32_t restart = 1;
  Append(request, IFLA_CAN_RESTART, &restart, sizeof(restart));
  CloseNest(request, data);
  CloseNest(request, info);
  return Ask(request, false, [](const nlmsghdr*) {});
}

}  // namespace annulus
