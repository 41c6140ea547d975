#pragma once

#include <chrono>
#include <cstdint>

namespace annulus {

/// Time of the host, passed in so that simulation runs in virtual time. Not thread-safe unless the class says so.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Monotonic time since an arbitrary start. Never goes back.
  [[nodiscard]] virtual std::chrono::nanoseconds Now() const = 0;

  /// Wall-clock time since 1970-01-01T00:00:00Z. May jump; used for labels, never for timing.
  [[nodiscard]] virtual std::chrono::nanoseconds WallNow() const = 0;

  /// Returns when Now() >= `deadline`. Real clocks sleep, manual clocks advance.
  virtual void SleepUntil(std::chrono::nanoseconds deadline) = 0;
};

/// The host's clocks (CLOCK_MONOTONIC, CLOCK_REALTIME). Thread-safe.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] std::chrono::nanoseconds Now() const override;
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override;
  void SleepUntil(std::chrono::nanoseconds deadline) override;
};

/// Virtual time: starts at 0 ns, wall clock at 2000-01-01T00:00:00Z, moves only when told to. Thread-bound.
class ManualClock final : public Clock {
 public:
  /// Wall time of virtual time 0: 2000-01-01T00:00:00Z in ns since 1970.
  static constexpr std::chrono::nanoseconds kWallStart = std::chrono::seconds(946'684'800);

  [[nodiscard]] std::chrono::nanoseconds Now() const override { return now_; }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return kWallStart + now_; }
  void SleepUntil(std::chrono::nanoseconds deadline) override;

 private:
  std::chrono::nanoseconds now_{0};
};

}  // namespace annulus
