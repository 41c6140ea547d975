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

std::optional<ReferenceBoardOptions> ReferenceBoardOf(const RingConfig& ring) {
  if (!ring.reference) return std::nullopt;
  ReferenceBoardOptions options;
  options.serial = ring.reference->board;
  for (const ReferenceSensor& sensor : ring.reference->sensors) options.channels.push_back(sensor.channel);
  return options;
}

std::optional<RecordedReference> RecordedReferenceOf(const RingConfig& ring) {
  if (!ring.reference) return std::nullopt;
  return RecordedReference{ring.reference->board, {}, ring.reference->sensors};
}

std::string AxisConfig::LinkText() const {
  if (const auto* serial = std::get_if<ModbusRtuOptions>(&link)) return serial->device;
  if (const auto* tcp = std::get_if<ModbusTcpOptions>(&link))
    return "tcp:" + tcp->host + ":" + std::to_string(tcp->port);
  return "sim";
}

}  // namespace annulus
