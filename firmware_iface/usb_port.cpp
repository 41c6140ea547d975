#include "firmware_iface/usb_port.h"

namespace annulus {

const char* UsbStatusText(UsbStatus status) {
  switch (status) {
    case UsbStatus::kCompleted:
      return "completed";
    case UsbStatus::kTimedOut:
      return "no answer in time";
    case UsbStatus::kCancelled:
      return "cancelled";
    case UsbStatus::kStall:
      return "the device refused (stall)";
    case UsbStatus::kNoDevice:
      return "the device is unplugged";
    case UsbStatus::kOverflow:
      return "the device sent more than was asked for";
    case UsbStatus::kNoMemory:
      return "no memory for USB transfers";
    case UsbStatus::kNoAccess:
      return "no permission";
    case UsbStatus::kBusy:
      return "the device is in use";
    case UsbStatus::kError:
      return "the transfer failed";
  }
  return "unknown";
}

std::string DeviceName(const UsbIdentity& identity) {
  if (identity.port_path.empty()) return identity.serial;
  return (identity.serial.empty() ? "" : identity.serial + " ") + "at port " + identity.port_path;
}

}  // namespace annulus
