#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/usb_port.h"

struct libusb_context;
struct libusb_device_handle;

namespace annulus {

/// A libusb session. All callbacks of libusb run inside HandleEvents, or inside a synchronous request of a port, on the
/// thread that called. They only put away what they are told.
class LibusbContext {
 public:
  static Result<std::unique_ptr<LibusbContext>> Make(Clock& clock);
  ~LibusbContext();
  LibusbContext(const LibusbContext&) = delete;
  LibusbContext& operator=(const LibusbContext&) = delete;

  [[nodiscard]] libusb_context* get() const { return context_; }
  [[nodiscard]] Clock& clock() const { return clock_; }
  /// Lets libusb handle what has happened; waits for one event until `deadline` at most.
  void HandleEvents(std::chrono::nanoseconds deadline);
  /// A transfer never ended: the session can not be closed safely any more, and stays open for the program's life.
  void Abandon() { abandoned_ = true; }

 private:
  LibusbContext(libusb_context* context, Clock& clock) : context_(context), clock_(clock) {}

  libusb_context* context_;
  Clock& clock_;
  bool abandoned_ = false;
};

/// A failed call of libusb (a negative return code), in our terms.
[[nodiscard]] UsbFailure FailureOf(int libusb_error, const std::string& what);

/// Takes over an open device whose interface is claimed. The session is borrowed. `transfer_memory` is for messages.
std::unique_ptr<UsbPort> MakeLibusbPort(LibusbContext& context, libusb_device_handle* handle, UsbIdentity identity,
                                        std::uint64_t transfer_memory);

/// The one interface of a ring board.
inline constexpr int kBoardInterface = 0;

}  // namespace annulus
