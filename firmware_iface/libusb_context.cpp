#include "firmware_iface/libusb_context.h"

#include <libusb.h>

#include <algorithm>

#include "base/log.h"

namespace annulus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// libusb is asked anew at least so often; the caller's loop looks at its own deadline.
constexpr nanoseconds kLongestWait = seconds(1);
constexpr nanoseconds kAfterFailure = milliseconds(1);

}  // namespace

Result<std::unique_ptr<LibusbContext>> LibusbContext::Make(Clock& clock) {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != 0) {
    return Fail("open the USB bus", std::string(libusb_error_name(code)) + ", " + libusb_strerror(code),
                "check that this system has USB (/dev/bus/usb) and that this program may use it");
  }
  return std::unique_ptr<LibusbContext>(new LibusbContext(context, clock));
}

LibusbContext::~LibusbContext() {
  if (abandoned_) {
    Log(LogLevel::kError, "the USB session is left open, because transfers in it never ended");
    return;
  }
  libusb_exit(context_);
}

void LibusbContext::HandleEvents(nanoseconds deadline) {
  const nanoseconds left = std::clamp(deadline - clock_.Now(), nanoseconds(0), kLongestWait);
  const auto whole = std::chrono::ceil<microseconds>(left);
  timeval timeout{};
  timeout.tv_sec = whole / seconds(1);
  timeout.tv_usec = (whole % seconds(1)).count();
  const int code = libusb_handle_events_timeout_completed(context_, &timeout, nullptr);
  // Whoever loops until the deadline must not burn the processor when libusb fails at once.
  if (code != 0 && code != LIBUSB_ERROR_INTERRUPTED) clock_.SleepUntil(clock_.Now() + std::min(left, kAfterFailure));
}

UsbFailure FailureOf(int libusb_error, const std::string& what) {
  const std::string detail = what + ": " + libusb_error_name(libusb_error);
  switch (libusb_error) {
    case LIBUSB_ERROR_TIMEOUT:
      return {UsbStatus::kTimedOut, detail};
    case LIBUSB_ERROR_PIPE:
      return {UsbStatus::kStall, detail};
    case LIBUSB_ERROR_NO_DEVICE:
      return {UsbStatus::kNoDevice, detail};
    case LIBUSB_ERROR_OVERFLOW:
      return {UsbStatus::kOverflow, detail};
    case LIBUSB_ERROR_NO_MEM:
      return {UsbStatus::kNoMemory, detail};
    case LIBUSB_ERROR_ACCESS:
      return {UsbStatus::kNoAccess, detail};
    case LIBUSB_ERROR_BUSY:
      return {UsbStatus::kBusy, detail};
    default:
      return {UsbStatus::kError, detail + ", " + libusb_strerror(libusb_error)};
  }
}

}  // namespace annulus
