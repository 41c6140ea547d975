#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace annulus {

/// How a USB transfer ended.
enum class UsbStatus {
  kCompleted,
  kTimedOut,   ///< Data that arrived before the time-out is delivered with it.
  kCancelled,  ///< A cancelled transfer may just as well end kCompleted.
  kStall,      ///< The endpoint is halted until ClearHalt.
  kNoDevice,   ///< Unplugged; the port answers nothing else from now on.
  kOverflow,   ///< The device sent more than was asked for.
  kNoMemory,   ///< The system's memory for transfers is used up (Linux: usbfs_memory_mb, shared by all devices).
  kNoAccess,   ///< This user may not use the device, or not yet: just after arrival udev may still be at work.
  kBusy,       ///< Another program has it open.
  kError,
};

/// The status in plain words.
[[nodiscard]] const char* UsbStatusText(UsbStatus status);

/// Why a request to a port failed; `detail` is what the system said, may be empty.
struct UsbFailure {
  UsbStatus status = UsbStatus::kError;
  std::string detail;
};

template <class T>
using UsbResult = tl::expected<T, UsbFailure>;

/// Names one submitted transfer of one port. Never used twice in the life of a port.
struct UsbToken {
  std::uint64_t value = 0;
  bool operator==(const UsbToken&) const = default;
};

/// Says which device this is, across unplugging: serial number and the place where it is plugged in.
struct UsbIdentity {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial;     ///< iSerialNumber.
  std::string port_path;  ///< Bus and hub ports, as "1-4.2".
};

/// The device as messages call it: "RB1003 at port 1-4.2", without what is not known.
[[nodiscard]] std::string DeviceName(const UsbIdentity& identity);

/// The set-up stage of a vendor request; its direction is that of the call.
struct UsbRequest {
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// A bulk IN transfer that has ended, whichever way.
struct UsbCompletion {
  UsbToken token;
  UsbStatus status = UsbStatus::kError;
  std::vector<std::byte> data;            ///< What arrived, also when `status` is not kCompleted.
  std::chrono::nanoseconds host_time{0};  ///< Host clock when the transfer ended, not when it was collected.
};

/// The seam to one USB device: submit, cancel, completion. Below it lies libusb, or a firmware model.
///
/// Every submitted transfer ends in exactly one completion, also after Cancel and after an unplug (status kNoDevice,
/// kError, or even kCompleted with data, after which the next submit fails: all three happen). A port must not be
/// destroyed while in_flight() > 0: cancel, then collect. Thread-bound: one thread calls, whatever runs below.
class UsbPort {
 public:
  virtual ~UsbPort() = default;

  [[nodiscard]] virtual const UsbIdentity& identity() const = 0;

  /// Vendor request, device to host: at most `length` bytes, within `timeout`.
  virtual UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                                      std::chrono::nanoseconds timeout) = 0;
  /// Vendor request, host to device, within `timeout`.
  virtual UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                                     std::chrono::nanoseconds timeout) = 0;
  /// Queues a bulk IN transfer of at most `length` bytes. Ends with the first short packet.
  virtual UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) = 0;
  /// Asks for a transfer to end early. Its completion still comes; an unknown token is ignored.
  virtual void Cancel(UsbToken token) = 0;
  /// Clears a halted endpoint.
  virtual UsbResult<void> ClearHalt(std::uint8_t endpoint) = 0;
  /// The next completion in the order of ending; nothing if none has come when the host clock reaches `deadline`.
  /// A deadline in the past only collects.
  virtual std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) = 0;
  /// Transfers submitted whose completion has not been collected.
  [[nodiscard]] virtual std::size_t in_flight() const = 0;
};

}  // namespace annulus
