#include "station/drift_lock.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace annulus {

Result<sim::OwnedFd> LockDriftHistory(const std::string& path) {
  const std::string attempted = "add to the drift history " + path;
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  sim::OwnedFd lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.get() < 0)
    return Fail(attempted, folder + ": " + std::strerror(errno), "name a file in a folder that is there");
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) == 0) return lock;
  return Fail(attempted,
              errno == EWOULDBLOCK ? "another program is adding to one in this folder" : std::strerror(errno),
              "try again when it has ended");
}

}  // namespace annulus
