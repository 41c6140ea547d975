#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// Vendor and product number of the ring's boards.
inline constexpr std::uint16_t kRingBoardVendor = 0x1209;
inline constexpr std::uint16_t kRingBoardProduct = 0xA180;

/// A device came or went.
struct UsbHotplug {
  enum class Kind { kArrived, kLeft };
  Kind kind = Kind::kArrived;
  UsbIdentity identity;  ///< For kLeft what was known of it; the serial number may be empty if it was never opened.
  std::chrono::nanoseconds host_time{0};
};

/// The seam to the USB devices of one kind: which there are, opening them, plug events. Below it lies libusb, or a
/// simulated bus. A port borrows its host. Thread-bound, as its ports; all calls on one host and its ports are from one
/// thread. A synchronous call never happens inside a hotplug callback: events are queued and read here.
class UsbHost {
 public:
  virtual ~UsbHost() = default;

  /// The devices that are plugged in, whether or not they can be opened. One whose serial number cannot be read is
  /// listed with an empty serial number.
  virtual UsbResult<std::vector<UsbIdentity>> List() = 0;
  /// Opens the device with this serial number (of several, the one at this port path if it is among them), or, where
  /// that is empty, the one at this port path. kNoDevice if there is none. Just after arrival the device node may not
  /// be there or not permitted yet (kError, kNoDevice, kNoAccess): try again later, see OpenPort. kBusy if another
  /// program has it.
  virtual UsbResult<std::unique_ptr<UsbPort>> Open(const UsbIdentity& identity) = 0;
  /// The next plug event; nothing if none has come when the host clock reaches `deadline`.
  virtual std::optional<UsbHotplug> WaitHotplug(std::chrono::nanoseconds deadline) = 0;
  /// Memory that all transfers in flight may use together, bytes (Linux: usbfs_memory_mb; 0: no limit, or not known).
  [[nodiscard]] virtual std::uint64_t transfer_memory() const = 0;
};

/// Watches and opens the ring's boards by libusb. The clock is borrowed and must be the host's (SystemClock).
/// Everything happens inside calls on the host or its ports, on the caller's thread; what belongs to another port is
/// queued there, stamped when libusb told of it.
Result<std::unique_ptr<UsbHost>> OpenLibusbHost(Clock& clock);

/// Opens a device that may just have come back, with retries after 50 ms, doubling up to 2 s, until `deadline`.
UsbResult<std::unique_ptr<UsbPort>> OpenPort(UsbHost& host, const UsbIdentity& identity, Clock& clock,
                                             std::chrono::nanoseconds deadline);

}  // namespace annulus
