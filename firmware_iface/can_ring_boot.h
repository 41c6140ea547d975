#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware_iface/can_ring_bus.h"
#include "firmware_iface/little_endian.h"
#include "firmware_iface/range_ring.h"

namespace annulus {

/// A board that has booted and introduced itself.
struct CanRingBoard {
  RingBoard board;
  RingLimits limits;
  std::size_t bus = 0;
  NodeId node = 1;
  bool fd = false;  ///< Sends its levels in FD frames.
};

/// Resets the communication of all nodes, waits until each of nodes 1 … board_count has booted on some bus, identifies
/// and configures them. The boards come back sorted by first sensor and cover each sensor of the ring once. Fails,
/// naming them, on nodes that stay silent until the boot deadline ("not ready"), are there twice, speak another
/// version, or do not fit.
Result<std::vector<CanRingBoard>> BootCanBoards(std::vector<CanRingBus>& buses, const CanRangeRingOptions& options,
                                                Clock& clock);

/// Waits a little for the reference board, whose bus BootCanBoards has just reset, identifies and configures it. Fails
/// if it stays silent, or is another board.
Result<CanRingBoard> BootReferenceBoard(std::vector<CanRingBus>& buses, const CanRangeRingOptions& options,
                                        Clock& clock);

/// The boards' own limits, and what each bus can carry: level frames, also those of the board beside the ring, fill
/// 80 % of it at most.
[[nodiscard]] RingLimits LimitsOf(std::vector<CanRingBus>& buses, const std::vector<CanRingBoard>& boards,
                                  const std::optional<CanRingBoard>& beside, std::uint16_t sensor_count);

/// Asks a board for its clock, once. `question` is a sub-index of object 2004h, 1 … 16: another one each time, so that
/// a late answer is never that of the next question.
Result<ClockExchange> AskCanClock(CanRingBus& bus, const CanRingBoard& board, std::uint8_t question,
                                  std::chrono::nanoseconds timeout, Clock& clock);

/// Attempts of an exchange that may be repeated.
inline constexpr int kSdoAttempts = 4;

/// Reads a number of exactly this size.
template <class Unsigned>
Result<Unsigned> ReadNumber(CanRingBus& bus, NodeId node, SdoAddress address, std::chrono::nanoseconds timeout,
                            int attempts = kSdoAttempts) {
  const auto bytes = bus.Upload(node, address, timeout, attempts);
  if (!bytes) return Fail(bytes);
  if (bytes->size() != sizeof(Unsigned)) {
    return Fail("read object " + SdoAddressText(address) + " of " + bus.NodeName(node),
                std::to_string(bytes->size()) + " bytes instead of " + std::to_string(sizeof(Unsigned)),
                "check the board's firmware version");
  }
  return GetLittleEndian<Unsigned>(std::span<const std::byte>(*bytes));
}

}  // namespace annulus
