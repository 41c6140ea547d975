#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

namespace annulus::sim {

/// A contact that follows its coil after a pull-in or drop-out time. A coil that changes back in time changes nothing.
class TimedContact {
 public:
  TimedContact(std::chrono::nanoseconds pull_in, std::chrono::nanoseconds drop_out)
      : pull_in_(pull_in), drop_out_(drop_out) {}

  void Drive(bool on, std::chrono::nanoseconds time) {
    if (on == driven_) return;
    driven_ = on;
    change_at_.reset();
    if (closed_ != on) change_at_ = time + (on ? pull_in_ : drop_out_);
  }
  /// When it will change, unless driven otherwise before.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> next() const { return change_at_; }
  void Advance(std::chrono::nanoseconds time) {
    if (!change_at_ || *change_at_ > time) return;
    closed_ = driven_ || (welds_ && closed_);
    change_at_.reset();
  }
  [[nodiscard]] bool closed() const { return closed_; }
  /// Once closed, now or later, it stays so for ever.
  void Weld() { welds_ = true; }

 private:
  std::chrono::nanoseconds pull_in_;
  std::chrono::nanoseconds drop_out_;
  bool driven_ = false;
  bool closed_ = false;
  bool welds_ = false;
  std::optional<std::chrono::nanoseconds> change_at_;
};

/// The electronics of a window watchdog relay: on after three rising edges whose distances are in the window, off when
/// an edge comes too early or none comes in time.
class WindowWatchdog {
 public:
  WindowWatchdog(std::chrono::nanoseconds shortest, std::chrono::nanoseconds longest)
      : shortest_(shortest), longest_(longest) {}

  void RisingEdge(std::chrono::nanoseconds time) {
    const bool in_window = last_ && time - *last_ >= shortest_ && time - *last_ <= longest_;
    good_ = in_window ? std::min(good_ + 1, kGoodEdges) : 1;
    last_ = time;
  }
  /// When it gives up waiting.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> next() const {
    if (!on()) return std::nullopt;
    return *last_ + longest_ + std::chrono::nanoseconds(1);
  }
  void Advance(std::chrono::nanoseconds time) {
    if (last_ && time > *last_ + longest_) good_ = 0;
  }
  [[nodiscard]] bool on() const { return good_ == kGoodEdges; }

 private:
  static constexpr int kGoodEdges = 3;

  std::chrono::nanoseconds shortest_;
  std::chrono::nanoseconds longest_;
  std::optional<std::chrono::nanoseconds> last_;
  int good_ = 0;
};

}  // namespace annulus::sim
