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
