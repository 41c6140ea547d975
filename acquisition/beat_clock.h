#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "base/clock.h"

namespace annulus {

/// The clock that the worker thread's devices are given: the same time as another clock's, and a sign of life whenever
/// a driver looks at it or waits by it. Drivers do that in all their loops, so that a thread that hangs in a call of
/// the system is told from one that waits for a device. Borrows the clock.
class BeatClock final : public Clock {
 public:
  explicit BeatClock(Clock& clock) : clock_(clock) {}
  /// Who hears of the signs of life; not before anything else is made of this clock.
  void OnBeat(std::function<void()> beat) { beat_ = std::move(beat); }

  [[nodiscard]] std::chrono::nanoseconds Now() const override {
    if (beat_) beat_();
    return clock_.Now();
  }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_.WallNow(); }
  /// Waits in pieces of at most kPiece.
  void SleepUntil(std::chrono::nanoseconds deadline) override {
    static constexpr std::chrono::milliseconds kPiece{50};
    for (auto now = Now(); now < deadline; now = Now())
      clock_.SleepUntil(std::min<std::chrono::nanoseconds>(deadline, now + kPiece));
  }

 private:
  Clock& clock_;
  std::function<void()> beat_;
};

/// Virtual time in which something happens every `period`, also while somebody waits: what another thread does, in one
/// thread and always the same. Thread-bound, but for Now and WallNow where those of `time` are for any thread.
class InterleavedClock final : public Clock {
 public:
  /// `time` passes when it is slept by, as fast as it likes: a manual clock at once, a paced one like the host's.
  explicit InterleavedClock(std::chrono::nanoseconds period,
                            std::unique_ptr<Clock> time = std::make_unique<ManualClock>())
      : clock_(std::move(time)), period_(period) {}

  [[nodiscard]] std::chrono::nanoseconds Now() const override { return clock_->Now(); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_->WallNow(); }
  void SleepUntil(std::chrono::nanoseconds deadline) override {
    while (tick_ && !ticking_ && next_ <= deadline) {
      clock_->SleepUntil(next_);
      next_ += period_;
      ticking_ = true;
      tick_();
      ticking_ = false;
    }
    clock_->SleepUntil(deadline);
  }
  /// From now on, first after one period.
  void Start(std::function<void()> tick) {
    tick_ = std::move(tick);
    next_ = Now() + period_;
  }

 private:
  std::unique_ptr<Clock> clock_;
  std::chrono::nanoseconds period_;
  std::function<void()> tick_;
  std::chrono::nanoseconds next_{0};
  bool ticking_ = false;
};

}  // namespace annulus
