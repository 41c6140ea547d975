#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/sha256.h"
#include "base/storage.h"

namespace annulus {

/// A file on its way into the store: written under a name of its own, hashed on the way. Removed when it goes, unless
/// it was kept. Thread-bound.
class StagedFile {
 public:
  StagedFile(Storage& storage, std::string folder, std::string part, std::unique_ptr<AppendFile> file);
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  Status Append(std::span<const std::byte> bytes);
  /// Brings it to the disk under the hash of what was written, and returns that. Once only.
  Result<std::string> Place();
  /// Its row is on the disk: it stays.
  void Keep() { kept_ = true; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  Storage& storage_;
  std::string folder_;
  std::string path_;  ///< Where it is now.
  std::unique_ptr<AppendFile> file_;
  Sha256 hash_;
  std::uint64_t bytes_ = 0;
  bool kept_ = false;
};

/// Files named by the SHA-256 of what is in them (sealed bytes), in FOLDER/ab/abcd…; never changed, only added and
/// removed. A row names a file only once it is on the disk. Reentrant.
class ContentFiles {
 public:
  ContentFiles(std::string folder, Storage& storage) : folder_(std::move(folder)), storage_(storage) {}

  Result<std::unique_ptr<StagedFile>> Stage();
  [[nodiscard]] bool Has(const std::string& hash) const;
  /// The bytes, held against the hash.
  Result<std::vector<std::byte>> Read(const std::string& hash);
  /// Unlinks and syncs the folder; success if it is not there.
  Status Remove(const std::string& hash);
  /// The hashes of all files, sorted.
  Result<std::vector<std::string>> All();
  /// Removes files that a process which is gone was writing.
  Status RemoveAbandoned();
  [[nodiscard]] std::string PathOf(const std::string& hash) const;

 private:
  std::string folder_;
  Storage& storage_;
};

/// True for 64 lower-case hex digits.
[[nodiscard]] bool IsContentHash(std::string_view text);

}  // namespace annulus
