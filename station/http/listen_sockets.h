#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "sim/unix_socket.h"

namespace annulus {

/// One TCP socket that listens, non-blocking.
struct ListenSocket {
  sim::OwnedFd fd;
  std::string address;
  bool ipv6 = false;
};

/// Listens on all of `addresses` (numeric, IPv4 or IPv6) with one port; 0: one that is free on all of them. An IPv6
/// address is left out if the system has no IPv6 or not this address. Fails if any other cannot be had, or none is
/// left.
Result<std::vector<ListenSocket>> OpenListenSockets(const std::vector<std::string>& addresses, std::uint16_t port);

/// The port of a socket that listens.
[[nodiscard]] std::uint16_t PortOf(const ListenSocket& socket);

}  // namespace annulus
