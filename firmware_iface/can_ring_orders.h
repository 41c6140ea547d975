#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware_iface/can_ring_boot.h"
#include "firmware_iface/can_ring_bus.h"

namespace annulus {

/// The orders that start and stop the boards of a ring on CAN, each made sure of (docs/wire_protocol.md §2.3). Borrows
/// everything.
class CanRingOrders {
 public:
  CanRingOrders(std::vector<CanRingBus>& buses, const std::vector<CanRingBoard>& boards,
                std::chrono::nanoseconds sdo_timeout, Clock& clock)
      : buses_(buses), boards_(boards), sdo_timeout_(sdo_timeout), clock_(clock) {}

  /// Makes all boards operational, with sequence 0 before them, and tells those that produce SYNC its period.
  Status Prepare(std::uint32_t period_us);
  /// Lets SYNC begin: with the first edge of the SYNC wire on all buses.
  Status StartSync();
  /// Ends SYNC and takes all boards out of operation. Goes on after a failure and returns the first.
  Status StopAll(int attempts);

 private:
  /// Orders all boards into a state and asks each whether it is there.
  Status EnterAll(NmtCommand command, NmtState state);
  /// The board that produces SYNC on a bus: its first.
  [[nodiscard]] std::optional<std::size_t> ProducerOf(std::size_t bus) const;
  [[nodiscard]] CanRingBus& BusOf(std::size_t board) { return buses_[boards_[board].bus]; }
  Status Write(std::size_t board, SdoAddress address, std::vector<std::byte> data, int attempts);
  Status WriteAndReadBack(std::size_t board, SdoAddress address, std::uint32_t value);
  Status SetProducer(std::size_t board, std::uint32_t producer_bit, int attempts);

  std::vector<CanRingBus>& buses_;
  const std::vector<CanRingBoard>& boards_;  ///< Sorted by first sensor.
  std::chrono::nanoseconds sdo_timeout_;
  Clock& clock_;
};

}  // namespace annulus
