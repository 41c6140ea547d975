#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "sim/unix_socket.h"

namespace annulus {

/// The process at the other end of a Unix socket.
struct PeerCredentials {
  std::int64_t pid = 0;
  std::uint32_t uid = 0;
  std::vector<std::uint32_t> groups;  ///< Its own and its supplementary ones.
};

/// Whether a process may talk to one that runs as `uid` in `gid`: root, the same user, or one of the group.
[[nodiscard]] bool MayTalk(const PeerCredentials& peer, std::uint32_t uid, std::uint32_t gid);

/// A listening Unix socket of mode 0660. While it lives nobody else of ours listens there; afterwards the name is gone.
/// Thread-bound.
class BoothSocket {
 public:
  /// A socket that was left by a process that died is replaced. Fails, and touches nothing, if somebody listens there
  /// or is about to, if the path is something else than a socket, or if others than us and root may change the names in
  /// its folder (a sticky one such as /tmp is good enough).
  static Result<BoothSocket> Listen(const std::string& path);
  BoothSocket(BoothSocket&& other) noexcept;
  BoothSocket& operator=(BoothSocket&&) = delete;
  ~BoothSocket();

  [[nodiscard]] int fd() const { return listener_.get(); }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// A connection that waits, with no-wait reading and writing; fd -1 if there is none, or if its process may not talk
  /// to us (it has then been closed).
  struct Connection {
    sim::OwnedFd fd;
    PeerCredentials peer;
  };
  Connection Accept();

 private:
  BoothSocket() = default;

  sim::OwnedFd lock_;  ///< The kernel lets go of it however we end.
  sim::OwnedFd listener_;
  std::string lock_path_;  ///< Empty until it is ours; removed at the end, as path_ is.
  std::string path_;
};

/// Where boothd listens unless told otherwise: annulus.sock in $RUNTIME_DIRECTORY (systemd's) or $XDG_RUNTIME_DIR, else
/// /run/annulus/annulus.sock.
[[nodiscard]] std::string DefaultBoothSocket();

}  // namespace annulus
