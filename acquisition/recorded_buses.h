#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <variant>
#include <vector>

#include "acquisition/bus_record.h"
#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

// Seams that give back what passed real ones. Time is the replay's: what was collected at a time is there from that
// time on, and a wait passes the time until then. Requests and orders are answered as they were. A driver that asks for
// more, or for something else, than the recorded one did (it meets faults that the recorded one did not) finds a device
// that falls silent. Borrow the clock. Thread-bound.

/// A board's port.
class RecordedUsbPort final : public UsbPort {
 public:
  RecordedUsbPort(UsbIdentity identity, ManualClock& clock) : identity_(std::move(identity)), clock_(clock) {}

  // What passed, in its order, each with the time of its record.
  void Load(bus_record::UsbControl control);
  void Load(std::chrono::nanoseconds time, bus_record::UsbEnded ended);
  void Load(bus_record::UsbRefused refused);

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override;
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override;
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override;
  void Cancel(UsbToken token) override;
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override;
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::size_t in_flight() const override { return pending_.size(); }

 private:
  struct Ended {
    std::chrono::nanoseconds collected{0};
    bus_record::UsbEnded ended;
  };
  struct Pending {
    UsbToken token;
    bool cancelled = false;
  };

  /// The answer to the next request of this kind, if there was one.
  std::optional<bus_record::UsbControl> Answer(bool in, UsbRequest request);
  /// The failure of this call, if it failed.
  std::optional<UsbFailure> Refusal(bus_record::UsbRefused::Call call, std::uint64_t number);
  UsbCompletion Complete(const std::deque<Pending>::iterator& which, UsbStatus status);

  UsbIdentity identity_;
  ManualClock& clock_;
  std::map<std::pair<bool, std::uint8_t>, std::deque<bus_record::UsbControl>> controls_;
  std::deque<std::variant<Ended, bus_record::UsbRefused>> events_;
  std::deque<Pending> pending_;
  std::uint64_t next_token_ = 1;
  std::uint64_t submits_ = 0;  ///< Since a transfer was collected.
  std::uint64_t clears_ = 0;   ///< Likewise.
};

/// A CAN bus.
class RecordedCanBus final : public CanBus {
 public:
  explicit RecordedCanBus(ManualClock& clock) : clock_(clock) {}

  void Load(std::chrono::nanoseconds time, bus_record::CanLinkRead link);
  void Load(std::chrono::nanoseconds time, bus_record::CanReceived received);
  void Load(std::chrono::nanoseconds time, bus_record::CanFailed failed);
  void Load(std::chrono::nanoseconds time, bus_record::CanOverflows overflows);

  CanResult<CanLink> ReadLink() override;
  CanResult<void> Send(const CanFrame& frame) override;
  CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t overflows() const override;
  CanResult<void> Reopen() override { return {}; }
  CanResult<void> Restart() override { return {}; }

 private:
  struct Event {
    std::chrono::nanoseconds time{0};
    std::variant<bus_record::CanReceived, bus_record::CanFailed> what;
  };

  ManualClock& clock_;
  std::vector<std::pair<std::chrono::nanoseconds, bus_record::CanLinkRead>> links_;
  std::vector<std::pair<std::chrono::nanoseconds, std::uint64_t>> overflows_;
  std::deque<Event> events_;
  std::uint64_t sends_ = 0;  ///< Since something was received.
};

}  // namespace annulus
