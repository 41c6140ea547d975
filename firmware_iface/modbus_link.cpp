#include "firmware_iface/modbus_link.h"

namespace annulus {
namespace {

const char* ExceptionText(std::uint8_t code) {
  switch (code) {
    case 1:
      return "function not supported";
    case 2:
      return "no such register";
    case 3:
      return "value not allowed";
    case 4:
      return "the device failed";
    case 5:
      return "accepted, takes long";
    case 6:
      return "the device is busy";
    default:
      return "exception of unknown meaning";
  }
}

}  // namespace

std::chrono::nanoseconds ModbusRtuWireTime(const ModbusRtuOptions& options, const ModbusRequest& request) {
  const auto written = static_cast<std::int64_t>(2 * request.values.size());
  const std::int64_t read = 2 * std::int64_t{request.read_count};
  // Unit, function and checksum both ways are 8 bytes; then addresses, counts and values.
  std::int64_t bytes = 8;
  switch (request.function) {
    case ModbusFunction::kReadRegisters:
      bytes += 4 + 1 + read;
      break;
    case ModbusFunction::kWriteRegister:
      bytes += 4 + 4;
      break;
    case ModbusFunction::kWriteRegisters:
      bytes += 5 + written + 4;
      break;
    case ModbusFunction::kWriteReadRegisters:
      bytes += 9 + written + 1 + read;
      break;
  }
  const std::int64_t bits = 1 + 8 + (options.parity == 'N' ? 0 : 1) + options.stop_bits;
  return std::chrono::nanoseconds(bytes * bits * 1'000'000'000 / options.baud);
}

std::string ModbusFailureText(const ModbusFailure& failure) {
  std::string text;
  switch (failure.fault) {
    case ModbusFault::kException:
      text = std::string("exception ") + std::to_string(failure.exception_code) + ", " +
             ExceptionText(failure.exception_code);
      break;
    case ModbusFault::kTimeout:
      text = "no reply in time";
      break;
    case ModbusFault::kLinkLost:
      text = "the link is lost";
      break;
    case ModbusFault::kBadReply:
      text = "a damaged reply";
      break;
  }
  return failure.detail.empty() ? text : text + " (" + failure.detail + ")";
}

}  // namespace annulus
