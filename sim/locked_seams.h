#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <vector>

#include "base/clock.h"
#include "base/priority_mutex.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/gpio_lines.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/usb_port.h"

namespace annulus::sim {

/// Lets several threads use one simulated booth in real time, each by seams of its own: a call on any of them holds one
/// mutex, and lets it go while the model waits. A model must therefore be whole whenever it looks at its clock's
/// SleepUntil, which those of sim are (virtual time interleaves in the same way).
class LockedTime final : public Clock {
 public:
  /// Borrows the clock, which must be thread-safe.
  explicit LockedTime(Clock& clock) : clock_(clock) {}

  [[nodiscard]] std::chrono::nanoseconds Now() const override { return clock_.Now(); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_.WallNow(); }
  /// Called by a model within a call on a locked seam only.
  void SleepUntil(std::chrono::nanoseconds deadline) override {
    mutex_.unlock();
    clock_.SleepUntil(deadline);
    mutex_.lock();
  }
  [[nodiscard]] PriorityMutex& mutex() { return mutex_; }

 private:
  Clock& clock_;
  PriorityMutex mutex_;
};

/// Seams that hold the time's mutex during each call. They borrow the time and, but for the lines, what they wrap.
[[nodiscard]] std::unique_ptr<UsbPort> MakeLocked(UsbPort& port, LockedTime& time);
[[nodiscard]] std::unique_ptr<CanBus> MakeLocked(CanBus& bus, LockedTime& time);
[[nodiscard]] std::unique_ptr<ModbusLink> MakeLocked(ModbusLink& link, LockedTime& time);
[[nodiscard]] std::unique_ptr<GpioLines> MakeLocked(std::unique_ptr<GpioLines> lines, LockedTime& time);

}  // namespace annulus::sim
