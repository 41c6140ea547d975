#include "sim/unix_socket.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kBetweenTries = milliseconds(20);

tl::unexpected<Error> FailWithErrno(const std::string& attempted, const char* advice) {
  return Fail(attempted, std::strerror(errno), advice);
}

Result<sockaddr_un> Address(const std::string& attempted, const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof(address.sun_path)) {
    return Fail(attempted, "a path of " + std::to_string(path.size()) + " bytes",
                "choose one of 1 to " + std::to_string(sizeof(address.sun_path) - 1));
  }
  std::copy(path.begin(), path.end(), std::begin(address.sun_path));
  return address;
}

const sockaddr* Generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

}  // namespace

OwnedFd::~OwnedFd() {
  if (fd_ >= 0) ::close(fd_);
}

OwnedFd& OwnedFd::operator=(OwnedFd&& other) noexcept {
  if (this != &other) {
    if (fd_ >= 0) ::close(fd_);
    fd_ = other.Release();
  }
  return *this;
}

int OwnedFd::Release() { return std::exchange(fd_, -1); }

Result<OwnedFd> ConnectUnixSocket(const std::string& path, nanoseconds deadline) {
  const std::string attempted = "connect to the socket " + path;
  const auto address = Address(attempted, path);
  if (!address) return Fail(address);
  SystemClock clock;
  while (true) {
    OwnedFd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (fd.get() < 0) return FailWithErrno(attempted, "free file descriptors");
    if (::connect(fd.get(), Generic(*address), sizeof(*address)) == 0) return fd;
    if (clock.Now() >= deadline) return FailWithErrno(attempted, "start the program that listens there");
    clock.SleepUntil(std::min(deadline, clock.Now() + kBetweenTries));
  }
}

Result<OwnedFd> AcceptUnixSocket(const std::string& path, nanoseconds deadline) {
  const std::string attempted = "listen on the socket " + path;
  const auto address = Address(attempted, path);
  if (!address) return Fail(address);
  const OwnedFd listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (listener.get() < 0) return FailWithErrno(attempted, "free file descriptors");
  ::unlink(path.c_str());
  if (::bind(listener.get(), Generic(*address), sizeof(*address)) != 0 || ::listen(listener.get(), 1) != 0) {
    return FailWithErrno(attempted, "choose a path that can be written");
  }
  const auto left = std::chrono::ceil<milliseconds>(deadline - SystemClock().Now());
  pollfd ready{listener.get(), POLLIN, 0};
  const int came = ::poll(&ready, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3'600'000)));
  OwnedFd fd(came > 0 ? ::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC) : -1);
  ::unlink(path.c_str());
  if (fd.get() < 0) return Fail(attempted, "nobody connected in time", "start the emulator with this socket");
  return fd;
}

}  // namespace annulus::sim
