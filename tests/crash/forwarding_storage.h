#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/storage.h"

namespace annulus::test {

/// An AppendFile that hands every call on; overridden call by call.
class ForwardingFile : public AppendFile {
 public:
  explicit ForwardingFile(std::unique_ptr<AppendFile> below) : below_(std::move(below)) {}
  Status Append(std::span<const std::byte> bytes) override { return below_->Append(bytes); }
  Status Sync() override { return below_->Sync(); }
  Status Reserve(std::uint64_t bytes) override { return below_->Reserve(bytes); }
  Status Close() override { return below_->Close(); }

 protected:
  std::unique_ptr<AppendFile> below_;
};

/// A Storage that hands every call on; overridden call by call. Borrows the one below.
class ForwardingStorage : public Storage {
 public:
  explicit ForwardingStorage(Storage& below) : below_(below) {}
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override { return below_.Create(path); }
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override {
    return below_.ReadAll(path, max_bytes);
  }
  Status Rename(const std::string& from, const std::string& to) override { return below_.Rename(from, to); }
  Status Remove(const std::string& path) override { return below_.Remove(path); }
  [[nodiscard]] bool Exists(const std::string& path) const override { return below_.Exists(path); }
  Status CreateFolder(const std::string& path) override { return below_.CreateFolder(path); }
  Result<std::uint64_t> FreeBytes(const std::string& path) override { return below_.FreeBytes(path); }
  Status SyncFolder(const std::string& path) override { return below_.SyncFolder(path); }
  Result<std::vector<std::string>> List(const std::string& folder) override { return below_.List(folder); }

 protected:
  Storage& below_;
};

}  // namespace annulus::test
