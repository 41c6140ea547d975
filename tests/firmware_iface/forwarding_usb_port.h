#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "firmware_iface/usb_port.h"

namespace annulus {

/// Passes everything on; each hook may change what comes back. An empty hook changes nothing.
class ForwardingUsbPort : public UsbPort {
 public:
  explicit ForwardingUsbPort(UsbPort& port) : port_(port) {}

  std::function<void(UsbCompletion& completion)> on_completion;
  std::function<void(UsbRequest request, std::vector<std::byte>& reply)> on_control_in;
  std::function<std::optional<UsbFailure>()> on_submit;
  int halts_cleared = 0;

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override {
    auto reply = port_.ControlIn(request, length, timeout);
    if (reply && on_control_in) on_control_in(request, *reply);
    return reply;
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override {
    return port_.ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    if (on_submit) {
      if (auto failure = on_submit()) return tl::unexpected<UsbFailure>(*failure);
    }
    return port_.SubmitBulkIn(endpoint, length);
  }
  void Cancel(UsbToken token) override { port_.Cancel(token); }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override {
    ++halts_cleared;
    return port_.ClearHalt(endpoint);
  }
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override {
    auto completion = port_.WaitCompletion(deadline);
    if (completion && on_completion) on_completion(*completion);
    return completion;
  }
  [[nodiscard]] std::size_t in_flight() const override { return port_.in_flight(); }

 private:
  UsbPort& port_;
};

}  // namespace annulus
