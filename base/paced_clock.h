#pragma once

#include <atomic>
#include <chrono>

#include "base/clock.h"

namespace annulus {

/// Time for a simulation that people and other programs look at: passes like the host's while its owner waits, and
/// stands still while its owner computes or is not given a processor. What the owner finds late on a busy computer is
/// therefore never late in this time; what was lost is not caught up. Starts at 0 ns; the wall clock is the host's.
/// SleepUntil is its owner's alone; the rest is thread-safe.
class PacedClock final : public Clock {
 public:
  /// Borrows the host's clock.
  explicit PacedClock(Clock& host) : host_(host), zero_(host.Now()) {}

  [[nodiscard]] std::chrono::nanoseconds Now() const override { return std::chrono::nanoseconds(now_.load()); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return host_.WallNow(); }
  void SleepUntil(std::chrono::nanoseconds deadline) override;

 private:
  Clock& host_;
  std::chrono::nanoseconds zero_;  ///< The host's time at this clock's 0, moved by what is lost.
  std::atomic<std::chrono::nanoseconds::rep> now_{0};
};

}  // namespace annulus
