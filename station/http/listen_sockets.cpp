#include "station/http/listen_sockets.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace annulus {
namespace {

/// Tries for a port that is free on all addresses, when any will do.
constexpr int kAnyPortTries = 16;

tl::unexpected<Error> FailListen(const std::string& address, std::uint16_t port, int error) {
  const std::string where = address + (port == 0 ? "" : ", port " + std::to_string(port));
  const char* advice = error == EADDRINUSE      ? "end the other program that listens there, or choose another port"
                       : error == EACCES        ? "choose a port above 1023"
                       : error == EADDRNOTAVAIL ? "give an address that this machine has"
                                                : "check the address";
  return Fail("listen on " + where, std::generic_category().message(error), advice);
}

Result<std::shared_ptr<addrinfo>> Resolve(const std::string& address, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) {
    return Fail("listen on " + address, ::gai_strerror(error), "give a numeric address, as 127.0.0.1 or ::1");
  }
  return std::shared_ptr<addrinfo>(found, &::freeaddrinfo);
}

/// A socket without a descriptor: IPv6 that this system does not have.
Result<ListenSocket> Open(const std::string& address, std::uint16_t port) {
  auto resolved = Resolve(address, port);
  if (!resolved) return Fail(resolved);
  const addrinfo& info = **resolved;
  ListenSocket socket{sim::OwnedFd(::socket(info.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), address,
                      info.ai_family == AF_INET6};
  const auto left_out = [&](int error) { return socket.ipv6 && (error == EAFNOSUPPORT || error == EADDRNOTAVAIL); };
  if (socket.fd.get() < 0) {
    if (left_out(errno)) return socket;
    return FailListen(address, port, errno);
  }
  const int on = 1;
  (void)::setsockopt(socket.fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  // Each family has a socket of its own, so that a peer's address has one form only.
  if (socket.ipv6) (void)::setsockopt(socket.fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof on);
  if (::bind(socket.fd.get(), info.ai_addr, info.ai_addrlen) != 0 || ::listen(socket.fd.get(), SOMAXCONN) != 0) {
    const int error = errno;
    if (!left_out(error)) return FailListen(address, port, error);
    socket.fd = sim::OwnedFd();
  }
  return socket;
}

struct Attempt {
  std::vector<ListenSocket> sockets;
  bool chosen_port_taken = false;  ///< The port that was free on the first address is not on another.
};

Result<Attempt> OpenAll(const std::vector<std::string>& addresses, std::uint16_t port) {
  Attempt attempt;
  const bool any = port == 0;
  for (const std::string& address : addresses) {
    auto socket = Open(address, port);
    if (!socket && any && port != 0) {
      attempt.chosen_port_taken = true;
      return attempt;
    }
    if (!socket) return Fail(socket);
    if (socket->fd.get() < 0) continue;
    attempt.sockets.push_back(std::move(*socket));
    port = PortOf(attempt.sockets.back());
  }
  return attempt;
}

}  // namespace

std::uint16_t PortOf(const ListenSocket& socket) {
  sockaddr_storage bound{};
  socklen_t length = sizeof bound;
  if (::getsockname(socket.fd.get(), reinterpret_cast<sockaddr*>(&bound), &length) != 0) return 0;
  const auto* v4 = reinterpret_cast<const sockaddr_in*>(&bound);
  const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&bound);
  return ntohs(bound.ss_family == AF_INET6 ? v6->sin6_port : v4->sin_port);
}

Result<std::vector<ListenSocket>> OpenListenSockets(const std::vector<std::string>& addresses, std::uint16_t port) {
  for (int i = 0; i < kAnyPortTries; ++i) {
    auto attempt = OpenAll(addresses, port);
    if (!attempt) return Fail(attempt);
    if (attempt->chosen_port_taken) continue;
    if (attempt->sockets.empty()) {
      return Fail("listen for browsers", "this machine has none of the addresses", "listen on 127.0.0.1");
    }
    return std::move(attempt->sockets);
  }
  return Fail("listen for browsers", "no port is free on all addresses", "choose one");
}

}  // namespace annulus
