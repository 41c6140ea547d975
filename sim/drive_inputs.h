#pragma once

#include <chrono>
#include <optional>

namespace annulus::sim {

/// Levels at the terminals of a drive, and of the brake that holds its axis. As it stands: nothing is wired to them.
struct DriveInputs {
  bool quick_stop = true;  ///< False: stop on the quick-stop ramp.
  bool sto_a = true;       ///< Safe torque off, two channels; either false: no torque.
  bool sto_b = true;
  bool brake_released = true;  ///< Of the brake itself, after its own delay.
  [[nodiscard]] bool torque() const { return sto_a && sto_b; }
};

/// A drive as the safety chain has it.
class WiredDrive {
 public:
  virtual ~WiredDrive() = default;
  /// The levels from `time` on. Said at every change, and whenever NextChange has come. Returns whether the drive's own
  /// brake output releases the brake.
  virtual bool Follow(std::chrono::nanoseconds time, DriveInputs inputs) = 0;
  /// When its brake output may change by itself; nothing: not before inputs or orders change.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> NextChange() const = 0;
};

/// The safety chain as the drive has it. Both call Follow in turn only, never each other in a circle.
class DriveWiring {
 public:
  virtual ~DriveWiring() = default;
  /// Brings the inputs up to the clock's time; the drive is told of each change at its exact time.
  virtual void Advance() = 0;
  /// An order has changed the drive: its brake output is to be looked at.
  virtual void DriveChanged() = 0;
};

}  // namespace annulus::sim
