#pragma once

#include <memory>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"
#include "sim/booth.h"
#include "station/config.h"

namespace annulus {

/// True if the configuration names no real device at all.
[[nodiscard]] bool AllSimulated(const Config& config);

/// Who and what stands in the simulated booth of a configuration.
Result<sim::BoothOptions> SimulatedBooth(const Config& config, Storage& storage);

/// The clock that the devices of a configuration run on, and the simulated booth behind those that are simulated. All
/// simulated: virtual time; one real device: the host's.
class DeviceGround {
 public:
  static Result<std::unique_ptr<DeviceGround>> Make(const Config& config, Storage& storage);

  [[nodiscard]] Clock& clock() { return *clock_; }
  /// Null if nothing of the configuration is simulated.
  [[nodiscard]] sim::BoothDevices* booth() { return booth_.get(); }

 private:
  std::unique_ptr<Clock> clock_;
  std::unique_ptr<sim::BoothDevices> booth_;
};

/// A device with the buses that it needs, in the order in which they may be destroyed (last member first). The ground
/// is borrowed and must live longer.
struct RingDevice {
  std::unique_ptr<UsbHost> usb;
  std::vector<std::unique_ptr<CanBus>> can;
  std::unique_ptr<RangeRing> ring;
};
struct AxisDevice {
  std::unique_ptr<ModbusLink> link;
  std::unique_ptr<ScanAxis> axis;
};

/// Open one device each, real or simulated as the configuration says, and identify it; nothing moves, no emitter is on.
Result<RingDevice> OpenRing(const RingConfig& config, DeviceGround& ground);
Result<AxisDevice> OpenAxis(const AxisConfig& config, DeviceGround& ground);
Result<std::unique_ptr<Interlock>> OpenInterlock(const InterlockConfig& config, DeviceGround& ground);

}  // namespace annulus
