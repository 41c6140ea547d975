#include "station/console/scratch_folder.h"

#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/log.h"

namespace annulus {
namespace {

namespace fs = std::filesystem;

constexpr long kTmpfs = 0x01021994;  ///< linux/magic.h

bool InMemory(const std::string& folder) {
  struct statfs disk {};
  return ::statfs(folder.c_str(), &disk) == 0 && static_cast<long>(disk.f_type) == kTmpfs;
}

class OwnScratch final : public ScratchFolder {
 public:
  OwnScratch(std::string path, std::string problem) : path_(std::move(path)), problem_(std::move(problem)) {}
  ~OwnScratch() override { Remove(path_); }

  Result<std::string> NewFolder() override {
    const std::string folder = path_ + "/" + std::to_string(++count_);
    if (::mkdir(folder.c_str(), S_IRWXU) != 0) {
      return Fail("make a folder for opened files", std::strerror(errno), "see whether there is memory left");
    }
    return folder;
  }
  void Remove(const std::string& folder) override {
    std::error_code failed;
    fs::remove_all(folder, failed);
    if (failed) Log(LogLevel::kError, "opened files could not be removed: " + failed.message());
  }
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] std::string problem() const override { return problem_; }

 private:
  std::string path_;
  std::string problem_;
  std::atomic<std::uint64_t> count_{0};
};

/// What consoles of ours have left that did not come to their end: folders "annulus-scratch-UID-PID-…" of no process.
void RemoveLeftOvers(const std::string& parent, const std::string& stem) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(parent, failed)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(stem)) continue;
    const long pid = std::strtol(name.c_str() + stem.size(), nullptr, 10);
    if (pid <= 0 || ::kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM) continue;
    std::error_code kept;
    fs::remove_all(entry.path(), kept);
  }
}

Result<std::unique_ptr<ScratchFolder>> MakeIn(const std::string& parent) {
  const std::string stem = "annulus-scratch-" + std::to_string(::geteuid()) + "-";
  RemoveLeftOvers(parent, stem);
  std::string path = parent + "/" + stem + std::to_string(::getpid()) + "-XXXXXX";
  if (::mkdtemp(path.data()) == nullptr) {
    return Fail("make the folder for opened files", path + ": " + std::strerror(errno),
                "give a folder that can be written");
  }
  const std::string problem =
      InMemory(path)
          ? ""
          : "opened files of customers lie on a disk while they are worked on (" + parent +
                " is no file system in memory); full-disk encryption is all that protects what is left there";
  return std::unique_ptr<ScratchFolder>(std::make_unique<OwnScratch>(path, problem));
}

}  // namespace

Result<std::unique_ptr<ScratchFolder>> ScratchFolder::Make(const std::string& preferred) {
  if (!preferred.empty()) return MakeIn(preferred);
  std::vector<std::string> parents{"/dev/shm"};
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != '\0') {
    parents.emplace_back(runtime);
  }
  for (const std::string& parent : parents) {
    if (!InMemory(parent)) continue;
    if (auto made = MakeIn(parent)) return made;
  }
  std::error_code failed;
  const fs::path disk = fs::temp_directory_path(failed);
  return MakeIn(failed ? "/tmp" : disk.string());
}

}  // namespace annulus
