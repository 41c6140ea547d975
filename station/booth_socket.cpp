#include "station/booth_socket.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/log.h"

namespace annulus {
namespace {

constexpr mode_t kSocketMode = 0660;
constexpr int kBacklog = 16;
constexpr std::size_t kMaxGroups = 1024;

using sim::OwnedFd;

tl::unexpected<Error> FailWithErrno(const std::string& attempted, const char* advice) {
  return Fail(attempted, std::strerror(errno), advice);
}

tl::unexpected<Error> AlreadyServed(const std::string& attempted) {
  return Fail(attempted, "another boothd serves it", "end that one first, or choose another --socket");
}

Status CheckFolder(const std::string& attempted, const std::string& path) {
  const std::filesystem::path given = std::filesystem::path(path).parent_path();
  const std::string folder = given.empty() ? "." : given.string();
  struct stat info {};
  if (::stat(folder.c_str(), &info) != 0) return FailWithErrno(attempted, "create its folder");
  if (!S_ISDIR(info.st_mode)) return Fail(attempted, folder + " is no folder", "choose another --socket");
  const bool ours = info.st_uid == ::geteuid() || info.st_uid == 0;
  const bool open_to_all = (info.st_mode & S_IWOTH) != 0 && (info.st_mode & S_ISVTX) == 0;
  if (!ours || open_to_all) {
    return Fail(attempted, folder + " can be changed by other users", "use a folder that only this user may write");
  }
  return {};
}

/// Takes the lock beside the socket. Two of us that start at the same time cannot both have it.
Result<OwnedFd> TakeLock(const std::string& attempted, const std::string& path) {
  while (true) {
    OwnedFd lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (lock.get() < 0) return FailWithErrno(attempted, "choose a path that can be written");
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) return AlreadyServed(attempted);
      return FailWithErrno(attempted, "choose a path on a local file system");
    }
    // Whoever had it before may have removed the file since it was opened: then the lock is nobody's.
    struct stat held {};
    struct stat named {};
    if (::fstat(lock.get(), &held) == 0 && ::stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
        held.st_dev == named.st_dev) {
      return lock;
    }
  }
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

/// Removes a socket that nobody listens on.
Status RemoveStale(const std::string& attempted, const std::string& path, const sockaddr_un& address) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) {
    if (errno == ENOENT) return {};
    return FailWithErrno(attempted, "choose another --socket");
  }
  if (!S_ISSOCK(info.st_mode)) return Fail(attempted, "it is there and no socket", "choose another --socket");
  const OwnedFd probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (probe.get() < 0) return FailWithErrno(attempted, "free file descriptors");
  // Anything but a refusal (connected, or a full queue) means that somebody is there.
  if (::connect(probe.get(), Generic(address), sizeof(address)) == 0 || errno != ECONNREFUSED) {
    return AlreadyServed(attempted);
  }
  if (::unlink(path.c_str()) != 0) return FailWithErrno(attempted, "remove the old socket by hand");
  return {};
}

PeerCredentials CredentialsOf(int fd) {
  PeerCredentials peer;
  ucred credentials{};
  socklen_t size = sizeof(credentials);
  // Unknown credentials are nobody's: such a peer may not talk.
  peer.uid = static_cast<std::uint32_t>(-1);
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return peer;
  peer.pid = credentials.pid;
  peer.uid = credentials.uid;
  peer.groups.push_back(credentials.gid);
  std::vector<gid_t> groups(kMaxGroups);
  size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) == 0) {
    groups.resize(size / sizeof(gid_t));
    peer.groups.insert(peer.groups.end(), groups.begin(), groups.end());
  }
  return peer;
}

}  // namespace

bool MayTalk(const PeerCredentials& peer, std::uint32_t uid, std::uint32_t gid) {
  return peer.uid == 0 || peer.uid == uid ||
         std::find(peer.groups.begin(), peer.groups.end(), gid) != peer.groups.end();
}

Result<BoothSocket> BoothSocket::Listen(const std::string& path) {
  const std::string attempted = "serve the booth on " + path;
  const auto address = Address(attempted, path);
  if (!address) return Fail(address);
  RETURN_IF_ERROR(CheckFolder(attempted, path));
  BoothSocket socket;
  auto lock = TakeLock(attempted, path + ".lock");
  if (!lock) return Fail(lock);
  socket.lock_ = std::move(*lock);
  socket.lock_path_ = path + ".lock";
  RETURN_IF_ERROR(RemoveStale(attempted, path, *address));
  socket.listener_ = OwnedFd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (socket.fd() < 0) return FailWithErrno(attempted, "free file descriptors");
  // Before it has a name, so that at no time more may connect; after it, because the umask takes from it then.
  ::fchmod(socket.fd(), kSocketMode);
  if (::bind(socket.fd(), Generic(*address), sizeof(*address)) != 0) {
    return FailWithErrno(attempted, "choose a path that can be written");
  }
  socket.path_ = path;
  if (::chmod(path.c_str(), kSocketMode) != 0 || ::listen(socket.fd(), kBacklog) != 0) {
    return FailWithErrno(attempted, "choose another --socket");
  }
  return socket;
}

BoothSocket::BoothSocket(BoothSocket&& other) noexcept
    : lock_(std::move(other.lock_)),
      listener_(std::move(other.listener_)),
      lock_path_(std::exchange(other.lock_path_, {})),
      path_(std::exchange(other.path_, {})) {}

BoothSocket::~BoothSocket() {
  // The names go while the lock is still held.
  if (!path_.empty()) ::unlink(path_.c_str());
  if (!lock_path_.empty()) ::unlink(lock_path_.c_str());
}

BoothSocket::Connection BoothSocket::Accept() {
  Connection connection;
  connection.fd = OwnedFd(::accept4(fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (connection.fd.get() < 0) return connection;
  connection.peer = CredentialsOf(connection.fd.get());
  if (!MayTalk(connection.peer, ::geteuid(), ::getegid())) {
    Log(LogLevel::kWarning, "booth socket: process " + std::to_string(connection.peer.pid) + " of user " +
                                std::to_string(connection.peer.uid) + " may not talk to the booth");
    connection.fd = OwnedFd();
  }
  return connection;
}

std::string DefaultBoothSocket() {
  // systemd gives several runtime folders with colons between them; ours is the first.
  for (const char* variable : {"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"}) {
    const char* folder = std::getenv(variable);
    if (folder == nullptr || *folder == '\0') continue;
    const std::string text(folder);
    return text.substr(0, text.find(':')) + "/annulus.sock";
  }
  return "/run/annulus/annulus.sock";
}

}  // namespace annulus
