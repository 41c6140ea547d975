#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "base/storage.h"
#include "sim/fault_actors.h"

namespace annulus::sim {

/// Which calls of a disk go wrong, and how. Thread-safe: recordings are synced by a thread of their own. Borrows the
/// clock, which only the thread that made this object asks.
class StorageFaultActor final : public FaultActor {
 public:
  /// The plan is borrowed: faults that wait for the n-th call begin in that call.
  StorageFaultActor(FaultGround ground, const FaultPlan& plan);
  ~StorageFaultActor() override;
  StorageFaultActor(const StorageFaultActor&) = delete;
  StorageFaultActor& operator=(const StorageFaultActor&) = delete;

  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;
  void Follow() override;

  /// The calling thread simulates, too: it lets the time pass itself.
  void SimulateHere();

  enum class Call { kCreate, kAppend, kSync, kReserve, kClose, kRead, kRename, kRemove, kFolder, kFreeBytes };
  /// What happens to a call.
  struct Fate {
    std::optional<FaultKind> fault;  ///< It fails like this.
    bool torn = false;               ///< Half of the bytes are written before.
    std::optional<std::uint64_t> free_bytes;
  };
  /// Of the call that is made now. Waits if the disk is slow.
  Fate Meet(Call call);
  /// Faults that have begun in a call since this was asked last.
  [[nodiscard]] std::vector<std::size_t> TakeBegun();

 private:
  struct Entry {
    std::size_t number = 0;
    Fault fault;
    bool holds = false;
    bool ended = false;
    std::uint64_t calls = 0;
    std::uint64_t left = 0;
  };
  [[nodiscard]] static bool Concerns(FaultKind kind, Call call);
  void WaitSlowly(std::chrono::nanoseconds delay, std::unique_lock<std::mutex>& lock);

  FaultGround ground_;
  std::set<std::thread::id> simulating_;
  std::mutex mutex_;
  std::condition_variable passed_;
  std::chrono::nanoseconds now_{0};  ///< As the owner saw the clock last.
  std::vector<Entry> entries_;
  std::vector<std::size_t> begun_;
};

/// A disk on which things go wrong. Everything that no fault touches is passed on. As reentrant as the disk below.
/// Borrows the disk and the faults; its files must not outlive it.
class FaultyStorage final : public Storage {
 public:
  FaultyStorage(Storage& storage, StorageFaultActor& faults) : storage_(storage), faults_(faults) {}

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override;
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override;
  Status Rename(const std::string& from, const std::string& to) override;
  Status Remove(const std::string& path) override;
  [[nodiscard]] bool Exists(const std::string& path) const override { return storage_.Exists(path); }
  [[nodiscard]] std::string Resolve(const std::string& path) const override { return storage_.Resolve(path); }
  Result<std::unique_ptr<AppendFile>> OpenDevice(const std::string& path) override { return storage_.OpenDevice(path); }
  Status CreateFolder(const std::string& path) override;
  Result<std::uint64_t> FreeBytes(const std::string& path) override;

 private:
  class File;
  Storage& storage_;
  StorageFaultActor& faults_;
};

}  // namespace annulus::sim
