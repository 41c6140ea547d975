#include "firmware_iface/can_bus.h"

namespace annulus {

const char* CanStateText(CanState state) {
  switch (state) {
    case CanState::kErrorActive:
      return "error-active";
    case CanState::kErrorWarning:
      return "error-warning";
    case CanState::kErrorPassive:
      return "error-passive";
    case CanState::kBusOff:
      return "bus-off";
    case CanState::kDown:
      return "down";
  }
  return "in an unknown state";
}

std::string CanFailureText(const CanFailure& failure) {
  const char* text = "the CAN interface failed";
  switch (failure.fault) {
    case CanFault::kQueueFull:
      text = "the transmit queue is full";
      break;
    case CanFault::kDown:
      text = "the CAN interface is down";
      break;
    case CanFault::kGone:
      text = "the CAN interface is no longer there";
      break;
    case CanFault::kError:
      break;
  }
  return failure.detail.empty() ? text : std::string(text) + " (" + failure.detail + ")";
}

bool IsCanFdSize(std::size_t size) {
  for (const std::size_t allowed : {12U, 16U, 20U, 24U, 32U, 48U, 64U}) {
    if (size == allowed) return true;
  }
  return size <= 8;
}

}  // namespace annulus
