#include "firmware_iface/usb_host.h"

#include <algorithm>

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr nanoseconds kFirstPause = milliseconds(50);
constexpr nanoseconds kLongestPause = seconds(2);

}  // namespace

UsbResult<std::unique_ptr<UsbPort>> OpenPort(UsbHost& host, const UsbIdentity& identity, Clock& clock,
                                             nanoseconds deadline) {
  for (nanoseconds pause = kFirstPause;; pause = std::min(2 * pause, kLongestPause)) {
    auto port = host.Open(identity);
    if (port || clock.Now() >= deadline) return port;
    clock.SleepUntil(std::min(deadline, clock.Now() + pause));
  }
}

}  // namespace annulus
