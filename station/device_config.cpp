#include "station/device_config.h"

namespace annulus {

const char* RingBusText(RingBus bus) {
  switch (bus) {
    case RingBus::kUsb:
      return "usb";
    case RingBus::kCan:
      return "can";
    case RingBus::kSimulated:
      break;
  }
  return "sim";
}

std::string AxisConfig::LinkText() const {
  if (const auto* serial = std::get_if<ModbusRtuOptions>(&link)) return serial->device;
  if (const auto* tcp = std::get_if<ModbusTcpOptions>(&link))
    return "tcp:" + tcp->host + ":" + std::to_string(tcp->port);
  return "sim";
}

}  // namespace annulus
