#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "base/clock.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"

namespace annulus {

/// A link with the drive of ContractDrive() behind it, and what can happen to both: what the contract suites of
/// ModbusLink and ScanAxis run on.
class ModbusRig {
 public:
  virtual ~ModbusRig() = default;

  [[nodiscard]] virtual ModbusLink& link() = 0;
  [[nodiscard]] virtual Clock& clock() = 0;
  /// The drive no longer answers, but keeps what it is sent, until Speak; it then carries that out.
  virtual void Silence() = 0;
  virtual void Speak() = 0;
  /// The cable or adapter is gone, until Plug.
  virtual void Unplug() = 0;
  virtual void Plug() = 0;

  double patience = 1.0;   ///< All times allowed are this many times longer, but the drive's heartbeat.
  bool real_time = false;  ///< Then the host may stop us for longer than the heartbeat: such runs are repeated.

  [[nodiscard]] std::chrono::nanoseconds Longer(std::chrono::nanoseconds time) const {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(time * patience);
  }
  [[nodiscard]] ModbusAxisOptions axis_options() const {
    return {Longer(std::chrono::milliseconds(30)), std::chrono::milliseconds(100)};
  }
};

struct NamedModbusRig {
  std::string name;
  std::function<std::unique_ptr<ModbusRig>()> make;
};

/// The drive that the suites expect: serial 4711, travel -60 … 2250 mm, 300 mm/s, 1500 mm/s^2. It stands 2 mm below its
/// home switch, so that homing takes half a second. Its clock is the host's.
inline sim::AxisDriveOptions ContractDrive(double patience) {
  sim::AxisDriveOptions options;
  options.start_z_mm = options.home_switch_z_mm - 2.0;
  options.start_window = std::chrono::milliseconds(static_cast<int>(25 * patience));
  options.clock_drift_ppm = 0.0;
  options.seed = 1000;  // clock offset 0: it is the seed modulo 1000 in ms
  return options;
}

}  // namespace annulus
