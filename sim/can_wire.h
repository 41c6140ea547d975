#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/can_timing.h"

namespace annulus::sim {

/// Something that hangs on a CAN bus and has a controller of its own: a board's firmware. Whoever carries the frames
/// (CanWire, ServeCanBoards) calls it; times never go back.
class CanStation {
 public:
  virtual ~CanStation() = default;

  /// A frame of another station is over.
  virtual void OnFrame(const CanFrame& frame, std::chrono::nanoseconds time) = 0;
  /// One of its own frames went out.
  virtual void OnSent(const CanFrame& frame, std::chrono::nanoseconds time) = 0;
  /// Its controller's state changed.
  virtual void OnState(CanState state, std::chrono::nanoseconds time) = 0;
  /// When it wants to act next without anybody's doing.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> NextTime() const = 0;
  /// Does what is due at `time`.
  virtual void Act(std::chrono::nanoseconds time) = 0;
  /// The frames that it wants to send now, in order; each is given out once.
  virtual std::vector<CanFrame> TakeFrames() = 0;
};

struct CanWireOptions {
  CanBitRates bit_rates;
  bool fd = false;                    ///< FD frames are allowed.
  std::size_t queue_length = 128;     ///< Frames that a host's transmit queue takes.
  std::size_t receive_frames = 4096;  ///< Frames kept for a host that does not collect; then the newest is lost.
  std::uint32_t restart_ms = 0;       ///< Host controllers: from bus-off back by themselves after this; 0: never.
};

/// A CAN bus in virtual time: arbitration by identifier, every frame as long as it can be (all stuff bits), error
/// counters and states of ISO 11898-1, collisions of equal identifiers, receive queues that overflow. Boards and hosts
/// hang on it. Thread-bound. Borrows the clock and the stations.
class CanWire {
 public:
  CanWire(CanWireOptions options, Clock& clock);
  ~CanWire();
  CanWire(const CanWire&) = delete;
  CanWire& operator=(const CanWire&) = delete;

  void Attach(CanStation& station);
  /// A controller for a host, as its driver sees it. Lives as long as the wire.
  CanBus& Connect(std::string name);

  /// Every transmission that touches this time is destroyed, as by a short circuit.
  void DisturbBetween(std::chrono::nanoseconds from, std::chrono::nanoseconds to) {
    disturbed_from_ = from;
    disturbed_to_ = to;
  }
  /// Makes a host's controller lose what it would receive next.
  void DropAtReceiver(CanBus& host, std::size_t frames);

  struct Traffic {
    std::uint64_t frames = 0;          ///< Carried whole.
    std::uint64_t errors = 0;          ///< Destroyed.
    std::chrono::nanoseconds busy{0};  ///< Time in which the bus was not free.
  };
  [[nodiscard]] const Traffic& traffic() const { return traffic_; }

  /// Carries everything up to the clock's now.
  void Advance();

 private:
  class Port;
  struct Contender;
  struct Flight {
    CanFrame frame;
    std::vector<Contender*> senders;
    bool collision = false;
    bool acknowledged = true;
    std::chrono::nanoseconds start{0};
    std::chrono::nanoseconds end{0};
  };

  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextEvent() const;
  void Process(std::chrono::nanoseconds time);
  void StartTransmission(std::chrono::nanoseconds time);
  void EndTransmission();
  void Fail(Contender& contender, int transmit_errors);
  void Deliver(const Flight& flight);
  void UpdateState(Contender& contender);
  void Recover(Contender& contender);
  void Poll(Contender& contender);
  [[nodiscard]] std::chrono::nanoseconds BitTime(int bits) const;

  CanWireOptions options_;
  Clock& clock_;
  std::vector<std::unique_ptr<Contender>> contenders_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::optional<Flight> flight_;
  std::chrono::nanoseconds time_{0};       ///< Up to here everything has happened.
  std::chrono::nanoseconds idle_from_{0};  ///< The bus is free from here on.
  std::chrono::nanoseconds disturbed_from_{0};
  std::chrono::nanoseconds disturbed_to_{0};
  Traffic traffic_;
};

}  // namespace annulus::sim
