#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/test_storage.h"

namespace annulus::test {

/// A disk in memory whose syncs can be held up, or fail, from another thread. Thread-safe but for inner().
class GatedStorage final : public Storage {
 public:
  /// The disk below; look at it while nobody writes.
  [[nodiscard]] TestStorage& inner() { return inner_; }
  /// Syncs wait from now on until Release.
  void HoldSyncs() {
    const std::lock_guard lock(mutex_);
    hold_ = true;
  }
  void Release() {
    const std::lock_guard lock(mutex_);
    hold_ = false;
    changed_.notify_all();
  }
  /// The next sync fails, those after it would work.
  void FailNextSync() {
    const std::lock_guard lock(mutex_);
    fail_sync_ = true;
  }
  /// Waits until a sync is held up.
  void WaitUntilHeld() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return held_; });
  }
  /// Waits until `count` syncs have succeeded.
  void WaitForSyncs(std::uint64_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return syncs_ >= count; });
  }
  [[nodiscard]] std::uint64_t syncs() const {
    const std::lock_guard lock(mutex_);
    return syncs_;
  }
  [[nodiscard]] std::uint64_t appends() const {
    const std::lock_guard lock(mutex_);
    return appends_;
  }
  /// Syncs that were asked for, failed ones too.
  [[nodiscard]] std::uint64_t sync_calls() const {
    const std::lock_guard lock(mutex_);
    return sync_calls_;
  }

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    auto file = inner_.Create(path);
    if (!file) return file;
    return std::make_unique<File>(*this, std::move(*file));
  }
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override {
    return inner_.ReadAll(path, max_bytes);
  }
  Status Rename(const std::string& from, const std::string& to) override { return inner_.Rename(from, to); }
  Status Remove(const std::string& path) override { return inner_.Remove(path); }
  [[nodiscard]] bool Exists(const std::string& path) const override { return inner_.Exists(path); }
  Status CreateFolder(const std::string& path) override { return inner_.CreateFolder(path); }
  Result<std::uint64_t> FreeBytes(const std::string& path) override { return inner_.FreeBytes(path); }

 private:
  class File final : public AppendFile {
   public:
    File(GatedStorage& storage, std::unique_ptr<AppendFile> inner) : storage_(storage), inner_(std::move(inner)) {}
    Status Append(std::span<const std::byte> bytes) override {
      const std::lock_guard lock(storage_.mutex_);
      ++storage_.appends_;
      return inner_->Append(bytes);
    }
    Status Sync() override {
      std::unique_lock lock(storage_.mutex_);
      ++storage_.sync_calls_;
      storage_.held_ = storage_.hold_;
      storage_.changed_.notify_all();
      storage_.changed_.wait(lock, [&] { return !storage_.hold_; });
      storage_.held_ = false;
      if (std::exchange(storage_.fail_sync_, false)) return Fail("sync", "Input/output error", "check the disk");
      const Status status = inner_->Sync();
      ++storage_.syncs_;
      storage_.changed_.notify_all();
      return status;
    }
    Status Reserve(std::uint64_t bytes) override { return inner_->Reserve(bytes); }
    Status Close() override { return inner_->Close(); }

   private:
    GatedStorage& storage_;
    std::unique_ptr<AppendFile> inner_;
  };

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  TestStorage inner_;
  bool hold_ = false;
  bool held_ = false;  ///< A sync waits.
  bool fail_sync_ = false;
  std::uint64_t syncs_ = 0;
  std::uint64_t sync_calls_ = 0;
  std::uint64_t appends_ = 0;
};

}  // namespace annulus::test
