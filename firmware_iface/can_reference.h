#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/can_ring_boot.h"
#include "firmware_iface/can_ring_bus.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_rules.h"

namespace annulus {

/// The reference board of a ring on CAN: the node after the ring's, on one of its buses. As UsbReference, its failures
/// end here, as its `trouble`. The buses are those of the ring, the same in every call. Thread-bound.
class CanReference {
 public:
  /// Without a board. `options`: of the ring, with a reference board.
  explicit CanReference(const CanRangeRingOptions& options);

  [[nodiscard]] const ReferenceBoard& board() const { return board_; }
  /// Nothing while it is absent.
  [[nodiscard]] const std::optional<CanRingBoard>& node() const { return node_; }

  /// Waits a little for its boot-up, and identifies and configures it; the ring's boards have just booted. A board that
  /// was not there the first time stays absent.
  void Boot(std::vector<CanRingBus>& buses, Clock& clock);
  /// Makes sure that it is operational, with sequence 0 before it; the ring's boards are. Levels are awaited from here.
  void Begin(std::vector<CanRingBus>& buses, std::chrono::nanoseconds level_period);
  void End(std::vector<CanRingBus>& buses);
  /// Waits until it is decided whether it tells of this level; at the deadline it is lost.
  void Await(std::uint32_t sequence, std::chrono::nanoseconds deadline, std::vector<CanRingBus>& buses, Clock& clock);
  /// Puts what it said of this level in its place in the level. Fails only on an emitter fault.
  Status Put(std::vector<CanRingBus>& buses, RingLevel& level);
  /// Its clock, or an Error, then it is lost. `question`: as AskCanClock.
  Result<ClockExchange> ReadClock(std::uint8_t question, std::vector<CanRingBus>& buses, Clock& clock);

 private:
  void Lose(const Error& error);
  [[nodiscard]] bool reads() const { return node_ && board_.trouble.empty(); }
  [[nodiscard]] CanNode& NodeOf(std::vector<CanRingBus>& buses) { return buses[node_->bus].nodes().at(node_->node); }
  /// Orders it into a state and asks whether it is there.
  Status Enter(NmtCommand command, NmtState state, CanRingBus& bus);

  CanRangeRingOptions options_;
  ReferenceBoard board_;
  bool absent_ = false;  ///< It was when the ring was opened.
  std::optional<CanRingBoard> node_;
  LossBucket losses_;
};

}  // namespace annulus
