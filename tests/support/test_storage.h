#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/storage.h"

namespace annulus::test {

/// How a call of TestStorage goes wrong.
enum class StorageFault {
  kIoError,     ///< The call does nothing and fails.
  kShortWrite,  ///< An Append keeps half of its bytes and fails; any other call fails as with kIoError.
};

/// A disk in memory that fails where it is told to. Every call of Storage or of its files that may fail counts as one
/// call: Create, Append, Sync, Reserve, Close, ReadAll, Rename, Remove, CreateFolder,
/// SyncFolder, List. Thread-bound; must outlive its
/// files.
class TestStorage final : public Storage {
 public:
  std::map<std::string, std::vector<std::byte>> files;                    ///< Content by path.
  std::uint64_t quota_bytes = std::numeric_limits<std::uint64_t>::max();  ///< Sum of all files; beyond: disk full.

  /// The `n`-th call from now on (1 = the next) fails with `fault`; those after it work.
  void FailCall(std::uint64_t n, StorageFault fault) {
    failing_call_ = calls_ + n;
    fault_ = fault;
  }
  /// Calls made so far.
  [[nodiscard]] std::uint64_t calls() const { return calls_; }
  /// True once the call of FailCall was made.
  [[nodiscard]] bool fault_hit() const { return failing_call_ != 0 && calls_ >= failing_call_; }

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    RETURN_IF_ERROR(Call("create " + path));
    if (files.contains(path)) return Fail("create " + path, "File exists", "choose another name or remove it first");
    files[path];
    return std::make_unique<File>(*this, path);
  }
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override {
    RETURN_IF_ERROR(Call("read " + path));
    const auto found = files.find(path);
    if (found == files.end()) return Fail("read " + path, "No such file or directory", "check the path");
    if (found->second.size() > max_bytes) return Fail("read " + path, "it is too large", "give a smaller file");
    return found->second;
  }
  Status Rename(const std::string& from, const std::string& to) override {
    RETURN_IF_ERROR(Call("rename " + from));
    auto node = files.extract(from);
    if (node.empty()) return Fail("rename " + from, "No such file or directory", "check the path");
    files[to] = std::move(node.mapped());
    return {};
  }
  Status Remove(const std::string& path) override {
    RETURN_IF_ERROR(Call("remove " + path));
    if (files.erase(path) == 0) return Fail("remove " + path, "No such file or directory", "check the path");
    return {};
  }
  [[nodiscard]] bool Exists(const std::string& path) const override { return files.contains(path); }
  Status CreateFolder(const std::string& path) override { return Call("create folder " + path); }
  Result<std::uint64_t> FreeBytes(const std::string& path) override {
    RETURN_IF_ERROR(Call("ask how much room is left for " + path));
    return quota_bytes - std::min(quota_bytes, TotalBytes());
  }
  Status SyncFolder(const std::string& path) override { return Call("sync the folder of " + path); }
  Result<std::vector<std::string>> List(const std::string& folder) override {
    RETURN_IF_ERROR(Call("list folder " + folder));
    const std::string start = folder.empty() || folder == "." ? "" : folder + "/";
    std::vector<std::string> names;
    for (const auto& [path, content] : files) {
      if (path.starts_with(start) && path.find('/', start.size()) == std::string::npos) {
        names.push_back(path.substr(start.size()));
      }
    }
    return names;
  }

 private:
  class File final : public AppendFile {
   public:
    File(TestStorage& storage, std::string path) : storage_(storage), path_(std::move(path)) {}

    Status Append(std::span<const std::byte> bytes) override {
      const Status status = storage_.Call("write " + path_);
      const bool torn = !status && storage_.fault_ == StorageFault::kShortWrite;
      const std::uint64_t room = storage_.quota_bytes - std::min(storage_.quota_bytes, storage_.TotalBytes());
      std::size_t kept = status ? bytes.size() : (torn ? bytes.size() / 2 : 0);
      kept = std::min<std::size_t>(kept, room);
      auto& content = storage_.files[path_];
      content.insert(content.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kept));
      if (status && kept < bytes.size()) return DiskFull();
      return status;
    }
    Status Sync() override { return storage_.Call("sync " + path_); }
    Status Reserve(std::uint64_t bytes) override {
      RETURN_IF_ERROR(storage_.Call("reserve for " + path_));
      const std::uint64_t used = storage_.TotalBytes();
      if (used > storage_.quota_bytes || bytes > storage_.quota_bytes - used) return DiskFull();
      return {};
    }
    Status Close() override { return storage_.Call("close " + path_); }

   private:
    [[nodiscard]] Status DiskFull() const {
      return Fail("write " + path_, "No space left on device", "free space on this disk or choose another");
    }

    TestStorage& storage_;
    std::string path_;
  };

  Status Call(const std::string& attempted) {
    ++calls_;
    if (calls_ != failing_call_) return {};
    return Fail(attempted, "Input/output error", "check the disk and the path");
  }
  [[nodiscard]] std::uint64_t TotalBytes() const {
    std::uint64_t total = 0;
    for (const auto& [path, content] : files) total += content.size();
    return total;
  }

  std::uint64_t calls_ = 0;
  std::uint64_t failing_call_ = 0;
  StorageFault fault_ = StorageFault::kIoError;
};

}  // namespace annulus::test
