#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "acquisition/scan.h"
#include "base/result.h"

namespace annulus {

/// Levels on their way from the thread that takes them to the one that shows them. Neither ever waits for the other:
/// when it is full, a level is dropped, for it is a preview that is lost and no data. Put is for one thread, everything
/// else for one other.
class LevelMailbox {
 public:
  static Result<std::unique_ptr<LevelMailbox>> Make();
  ~LevelMailbox();
  LevelMailbox(const LevelMailbox&) = delete;
  LevelMailbox& operator=(const LevelMailbox&) = delete;

  /// Keeps a copy if anybody wants levels. Takes memory only until all slots have been used once.
  void Put(const ScanLevel& level);

  /// Until Want nothing is kept.
  void Want() { wanted_.store(true, std::memory_order_relaxed); }
  void Refuse() { wanted_.store(false, std::memory_order_relaxed); }
  /// The oldest level that waits; false: none.
  bool Take(ScanLevel& level);
  /// Can be polled for reading: levels have come since the last ClearSignal.
  [[nodiscard]] int signal() const { return signal_; }
  void ClearSignal();
  /// Levels dropped since the start.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kSlots = 64;  // two seconds of levels

  explicit LevelMailbox(int signal) : signal_(signal) {}

  int signal_;
  std::atomic<bool> wanted_{false};
  std::atomic<std::uint64_t> dropped_{0};
  // A ring with one writer and one reader: slots from taken_ to put_ are full, modulo kSlots.
  std::array<ScanLevel, kSlots> slots_;
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> taken_{0};
};

}  // namespace annulus
