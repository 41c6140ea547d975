#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "acquisition/scan.h"
#include "base/reference_sensor.h"
#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/range_ring.h"

namespace annulus {

/// Which bus the ring hangs on.
enum class RingBus { kSimulated, kUsb, kCan };
/// As the configuration writes it: "sim", "usb", "can".
[[nodiscard]] const char* RingBusText(RingBus bus);

/// [ring] reference
struct ReferenceConfig {
  std::uint32_t board = 0;  ///< Serial number.
  std::vector<ReferenceSensor> sensors;
};

/// [ring]
struct RingConfig {
  RingBus bus = RingBus::kSimulated;
  double radius_mm = 600.0;
  std::map<std::uint32_t, std::uint16_t> boards;       ///< Board serial → first sensor; empty: as the boards say.
  std::vector<std::string> can_interfaces = {"can0"};  ///< For bus = "can"; the boards may be spread over several.
  std::optional<ReferenceConfig> reference;            ///< Sensors at the wall.
};

/// What the ring's driver is to know of them.
[[nodiscard]] std::optional<ReferenceBoardOptions> ReferenceBoardOf(const RingConfig& ring);
/// What a recording says of them; the board's firmware is not known yet.
[[nodiscard]] std::optional<RecordedReference> RecordedReferenceOf(const RingConfig& ring);

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
