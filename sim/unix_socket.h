#pragma once

#include <chrono>
#include <string>

#include "base/clock.h"
#include "base/result.h"

namespace annulus::sim {

/// Owns a file descriptor.
class OwnedFd {
 public:
  OwnedFd() = default;
  explicit OwnedFd(int fd) : fd_(fd) {}
  OwnedFd(OwnedFd&& other) noexcept : fd_(other.Release()) {}
  OwnedFd& operator=(OwnedFd&& other) noexcept;
  OwnedFd(const OwnedFd&) = delete;
  OwnedFd& operator=(const OwnedFd&) = delete;
  ~OwnedFd();

  [[nodiscard]] int get() const { return fd_; }
  /// Gives the descriptor away.
  int Release();

 private:
  int fd_ = -1;
};

/// Connects to the Unix socket at `path`; tries again until `deadline` of the system's clock, since the program that
/// listens there may still be starting.
Result<OwnedFd> ConnectUnixSocket(const std::string& path, std::chrono::nanoseconds deadline);
/// Makes a Unix socket at `path` (an older one is replaced), waits for one peer until `deadline`, and removes the name.
Result<OwnedFd> AcceptUnixSocket(const std::string& path, std::chrono::nanoseconds deadline);

}  // namespace annulus::sim
