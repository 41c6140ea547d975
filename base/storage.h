#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace annulus {

/// A file being written front to back. Destruction closes it without a sync. Thread-bound.
class AppendFile {
 public:
  virtual ~AppendFile() = default;
  /// Appends all of `bytes` with one write() where the system allows. On failure the file may hold a prefix.
  virtual Status Append(std::span<const std::byte> bytes) = 0;
  /// Data to the disk (fdatasync). A failure is final: the file is bad and must not be synced again.
  virtual Status Sync() = 0;
  /// Reserves `bytes` more on the disk without changing the file's size.
  virtual Status Reserve(std::uint64_t bytes) = 0;
  /// Closes and reports what only close() tells. Nothing may be called afterwards.
  virtual Status Close() = 0;
};

/// The seam between the program and disks. Paths are the operating system's.
class Storage {
 public:
  virtual ~Storage() = default;
  /// Creates `path` for appending; fails if it exists.
  virtual Result<std::unique_ptr<AppendFile>> Create(const std::string& path) = 0;
  /// The whole file. Fails on a directory, a missing file, or over `max_bytes`.
  virtual Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) = 0;
  /// Atomically gives `from` the name `to`, replacing it, and syncs the folder. What is no regular file is never
  /// replaced (a device, a pipe): an Error.
  virtual Status Rename(const std::string& from, const std::string& to) = 0;
  virtual Status Remove(const std::string& path) = 0;
  [[nodiscard]] virtual bool Exists(const std::string& path) const = 0;
  /// The file that `path` stands for: links followed.
  [[nodiscard]] virtual std::string Resolve(const std::string& path) const { return path; }
  /// Opens a device, pipe or terminal for writing; null if `path` is none of these. Never waits for a reader.
  virtual Result<std::unique_ptr<AppendFile>> OpenDevice(const std::string& path) {
    static_cast<void>(path);
    return std::unique_ptr<AppendFile>();
  }
  /// Creates a folder and its parents; success if it exists.
  virtual Status CreateFolder(const std::string& path) = 0;
  /// Bytes that this program may still write to the disk that `path` (a file that may not exist yet) lies on.
  virtual Result<std::uint64_t> FreeBytes(const std::string& path) = 0;
  /// Brings the name of `path` (a file) to the disk: syncs the folder that it lies in. Where names are durable at once:
  /// nothing to do.
  virtual Status SyncFolder(const std::string& path) {
    static_cast<void>(path);
    return {};
  }
  /// Names (without the folder) of the regular files in a folder, sorted.
  virtual Result<std::vector<std::string>> List(const std::string& folder) {
    return Fail("list " + folder, "this storage has no folders", "give the path of a file");
  }
  /// True while a program holds the file open for appending.
  [[nodiscard]] virtual bool InUse(const std::string& path) const {
    static_cast<void>(path);
    return false;
  }
};

/// The real file system. Reentrant.
class PosixStorage final : public Storage {
 public:
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override;
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override;
  Status Rename(const std::string& from, const std::string& to) override;
  Status Remove(const std::string& path) override;
  [[nodiscard]] bool Exists(const std::string& path) const override;
  [[nodiscard]] std::string Resolve(const std::string& path) const override;
  Result<std::unique_ptr<AppendFile>> OpenDevice(const std::string& path) override;
  Status CreateFolder(const std::string& path) override;
  Result<std::uint64_t> FreeBytes(const std::string& path) override;
  Status SyncFolder(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& folder) override;
  /// By the advisory lock that Create takes.
  [[nodiscard]] bool InUse(const std::string& path) const override;
};

/// Largest input file that any command reads: 4 GiB.
inline constexpr std::uint64_t kMaxInputBytes = std::uint64_t{4} << 30;

/// Name under which `path` is written before it is renamed: beside it, with this process's id.
[[nodiscard]] std::string TemporaryName(const std::string& path);

/// Writes `bytes` under a temporary name beside `path`, syncs, then renames. On failure nothing is left at either name
/// (an existing `path` stays as it was). A link is followed; a device, pipe or terminal is written to.
Status WriteFileAtomically(Storage& storage, const std::string& path, std::span<const std::byte> bytes);
/// The same for text.
Status WriteFileAtomically(Storage& storage, const std::string& path, const std::string& text);
/// The whole file as text, at most kMaxInputBytes.
Result<std::string> ReadTextFile(Storage& storage, const std::string& path);

}  // namespace annulus
