#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "acquisition/beat_clock.h"
#include "acquisition/bus_tap.h"
#include "base/clock.h"
#include "base/priority_mutex.h"
#include "base/result.h"
#include "base/storage.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"
#include "sim/booth.h"
#include "sim/fault_injector.h"
#include "sim/locked_seams.h"
#include "station/config.h"

namespace annulus {

/// True if the configuration names no real device at all.
[[nodiscard]] bool AllSimulated(const Config& config);

/// Who and what stands in the simulated booth of a configuration.
Result<sim::BoothOptions> SimulatedBooth(const Config& config, Storage& storage);

/// How time passes.
enum class Pace {
  kAsFastAsPossible,  ///< Virtual time, where nothing of the configuration is real; else the host's.
  kPaced,             ///< The same, but no faster than the host's: for people and programs that look on (PacedClock).
  kRealTime,          ///< The host's, with threads.
};

/// The clocks that the devices of a configuration run on, and the simulated booth behind those that are simulated.
class DeviceGround {
 public:
  static Result<std::unique_ptr<DeviceGround>> Make(const Config& config, Storage& storage,
                                                    Pace pace = Pace::kAsFastAsPossible);
  DeviceGround(const DeviceGround&) = delete;
  DeviceGround& operator=(const DeviceGround&) = delete;
  ~DeviceGround();

  /// Of the interlock and of whoever waits.
  [[nodiscard]] Clock& clock() { return *clock_; }
  /// Of ring and axis; shows the same time.
  [[nodiscard]] BeatClock& worker_clock() { return *worker_clock_; }
  /// Null where time is the host's.
  [[nodiscard]] InterleavedClock* virtual_time() { return virtual_time_; }
  /// Null if nothing of the configuration is simulated. In real time the booth belongs to the threads that use its
  /// seams: hold Hold() while you touch it otherwise.
  [[nodiscard]] sim::BoothDevices* booth() { return booth_.get(); }
  [[nodiscard]] std::unique_lock<PriorityMutex> Hold();
  /// What goes wrong by plan ([sim] faults); null: nothing.
  [[nodiscard]] sim::FaultInjector* faults() { return faults_.get(); }

  /// The seams of the simulated booth, safe for one thread each in real time. Requires booth().
  [[nodiscard]] std::vector<UsbPort*> usb_ports();
  [[nodiscard]] ModbusLink& axis_link();
  Result<std::unique_ptr<GpioLines>> RequestLines(const std::vector<GpioLineSpec>& lines);

 private:
  DeviceGround() = default;

  SystemClock host_;
  std::unique_ptr<Clock> clock_;
  InterleavedClock* virtual_time_ = nullptr;
  std::unique_ptr<BeatClock> worker_clock_;
  std::unique_ptr<sim::LockedTime> locked_;  ///< Null in virtual time.
  std::unique_ptr<sim::BoothDevices> booth_;
  std::unique_ptr<sim::FaultInjector> faults_;
  std::vector<std::unique_ptr<UsbPort>> locked_ports_;
  std::unique_ptr<ModbusLink> locked_link_;
};

/// A device with the buses that it needs, in the order in which they may be destroyed (last member first). The ground
/// is borrowed and must live longer, and so must the tap.
struct RingDevice {
  std::unique_ptr<UsbHost> usb;
  std::unique_ptr<UsbHost> tapped_usb;
  std::vector<std::unique_ptr<CanBus>> can;
  std::vector<std::unique_ptr<CanBus>> tapped_can;
  std::vector<std::unique_ptr<UsbPort>> tapped_ports;
  std::unique_ptr<RangeRing> ring;
};
struct AxisDevice {
  std::unique_ptr<ModbusLink> link;
  std::unique_ptr<ModbusLink> tapped_link;
  std::unique_ptr<ScanAxis> axis;
};

/// Open one device each, real or simulated as the configuration says, and identify it; nothing moves, no emitter is on.
/// With a tap, all that passes the buses is told to it.
Result<RingDevice> OpenRing(const RingConfig& config, DeviceGround& ground, BusTap* tap = nullptr);
Result<AxisDevice> OpenAxis(const AxisConfig& config, DeviceGround& ground, BusTap* tap = nullptr);
Result<std::unique_ptr<Interlock>> OpenInterlock(const InterlockConfig& config, DeviceGround& ground);

}  // namespace annulus
