#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/modbus_link.h"

namespace annulus {

/// Which bus the ring hangs on.
enum class RingBus { kSimulated, kUsb, kCan };
/// As the configuration writes it: "sim", "usb", "can".
[[nodiscard]] const char* RingBusText(RingBus bus);

/// [ring]
struct RingConfig {
  RingBus bus = RingBus::kSimulated;
  double radius_mm = 600.0;
  std::map<std::uint32_t, std::uint16_t> boards;       ///< Board serial → first sensor; empty: as the boards say.
  std::vector<std::string> can_interfaces = {"can0"};  ///< For bus = "can"; the boards may be spread over several.
};

/// [axis]. `link` is the simulated drive, a serial port, or a network address.
struct AxisConfig {
  struct Simulated {};
  std::variant<Simulated, ModbusRtuOptions, ModbusTcpOptions> link;
  AxisRegisterMap register_map;
  [[nodiscard]] bool simulated() const { return std::holds_alternative<Simulated>(link); }
  /// As the configuration writes it: "sim", "/dev/serial/by-id/…", "tcp:HOST:PORT".
  [[nodiscard]] std::string LinkText() const;
};

/// [interlock]
struct InterlockConfig {
  bool simulated = true;  ///< No [interlock] section, or chip = "sim".
  InterlockWiring wiring = InterlockWiring::Default();
};

}  // namespace annulus
