#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "base/clock.h"
#include "base/result.h"

namespace annulus {

/// The four function codes that we use.
enum class ModbusFunction : std::uint8_t {
  kReadRegisters = 0x03,       ///< FC03: reads; uses read_address, read_count.
  kWriteRegister = 0x06,       ///< FC06: writes one; uses write_address, values[0].
  kWriteRegisters = 0x10,      ///< FC16: writes; uses write_address, values.
  kWriteReadRegisters = 0x17,  ///< FC23: writes, then reads, in one transaction.
};

/// One register transaction. The unit address belongs to the link.
struct ModbusRequest {
  ModbusFunction function = ModbusFunction::kReadRegisters;
  std::uint16_t write_address = 0;
  std::vector<std::uint16_t> values;  ///< To write; at most 121 (FC23).
  std::uint16_t read_address = 0;
  std::uint16_t read_count = 0;  ///< At most 125.
};

enum class ModbusFault {
  kException,  ///< The device refused; exception_code says why (1 function, 2 address, 3 value, 4 failure, 6 busy).
  kTimeout,    ///< No reply in time. The request may still be carried out, and its reply may still come.
  kLinkLost,   ///< The port or connection is gone.
  kBadReply,   ///< Checksum, length or function of the reply is wrong.
};

struct ModbusFailure {
  ModbusFault fault = ModbusFault::kTimeout;
  std::uint8_t exception_code = 0;
  std::string detail;  ///< What the layer below said; may be empty.
};

/// The failure in plain words.
[[nodiscard]] std::string ModbusFailureText(const ModbusFailure& failure);

/// The registers read (empty for pure writes), or why there are none.
using ModbusReply = tl::expected<std::vector<std::uint16_t>, ModbusFailure>;

/// The seam to one Modbus device. Below it lies libmodbus (RTU or TCP), or a model of a drive.
///
/// Modbus RTU has no transaction number, so a link can not tell a late reply to an earlier request from the reply to
/// this one: whoever calls must put something into the registers that tells (see ScanAxis). Thread-bound.
class ModbusLink {
 public:
  virtual ~ModbusLink() = default;

  /// Sends one request and waits for its whole reply, at most `timeout`, however the bytes trickle in. Never repeats a
  /// request by itself.
  virtual ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) = 0;
  /// How long request and reply take on the line, without the device's own time; 0 where that is no matter.
  [[nodiscard]] virtual std::chrono::nanoseconds WireTime(const ModbusRequest& /*request*/) const { return {}; }
  /// Throws away whatever has arrived unasked. Used after the quiet time that follows an error.
  virtual void DiscardInput() = 0;
  /// Closes the port or connection at once (TCP: by reset, so that nothing queued is delivered). From now on, and after
  /// any kLinkLost, everything but Reopen answers kLinkLost.
  virtual void Close() = 0;
  /// Closes, and opens anew under the name it was first opened by.
  virtual tl::expected<void, ModbusFailure> Reopen() = 0;
};

struct ModbusRtuOptions {
  std::string device;  ///< By a name that stays: /dev/serial/by-id/…
  int baud = 115'200;  ///< 1200 … 921 600, as the kernel's termios knows them.
  char parity = 'E';   ///< N, E or O.
  int stop_bits = 1;   ///< 1 or 2.
  int unit = 1;        ///< 1 … 247.
};
struct ModbusTcpOptions {
  std::string host;  ///< IPv4 or IPv6 address in digits: how long a name server takes cannot be bounded.
  int port = 502;
  int unit = 1;  ///< 0 … 255.
  std::chrono::nanoseconds connect_timeout = std::chrono::seconds(1);
};

/// Opens a serial port or a connection by libmodbus. The clock is borrowed and must be the host's. Fails on options
/// that make no sense, on a port that is missing, forbidden or in use under whatever name, on a host that does not
/// answer.
Result<std::unique_ptr<ModbusLink>> OpenModbusRtu(const ModbusRtuOptions& options, Clock& clock);
Result<std::unique_ptr<ModbusLink>> OpenModbusTcp(const ModbusTcpOptions& options, Clock& clock);
/// How long a transaction's request and reply take on a serial line of this baud rate, parity and stop bits.
[[nodiscard]] std::chrono::nanoseconds ModbusRtuWireTime(const ModbusRtuOptions& options, const ModbusRequest& request);
/// How requests are framed: as on Modbus TCP, or as on a serial line.
enum class ModbusFraming { kTcp, kRtu };
/// Speaks Modbus over a descriptor that is connected already, and owns it from now on. Reopen fails. For peers without
/// a name: a socket pair, a pipe's ends joined.
Result<std::unique_ptr<ModbusLink>> AdoptModbusDescriptor(int fd, ModbusFraming framing, int unit);
/// Serial ports by the names that stay (/dev/serial/by-id), full paths in alphabetical order; empty where there are
/// none.
[[nodiscard]] std::vector<std::string> ListSerialPorts();

}  // namespace annulus
