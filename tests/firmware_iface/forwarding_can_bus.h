#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>

#include "firmware_iface/can_bus.h"

namespace annulus {

/// Passes everything on; a test changes what it needs. Borrows the bus.
class ForwardingCanBus final : public CanBus {
 public:
  explicit ForwardingCanBus(CanBus& bus) : bus_(bus) {}

  std::function<void(CanReception& reception)> on_receive;

  CanResult<CanLink> ReadLink() override { return bus_.ReadLink(); }
  CanResult<void> Send(const CanFrame& frame) override { return bus_.Send(frame); }
  CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) override {
    auto received = bus_.Receive(deadline);
    if (received && *received && on_receive) on_receive(**received);
    return received;
  }
  [[nodiscard]] std::uint64_t overflows() const override { return bus_.overflows(); }
  CanResult<void> Reopen() override { return bus_.Reopen(); }
  CanResult<void> Restart() override { return bus_.Restart(); }

 private:
  CanBus& bus_;
};

}  // namespace annulus
