#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <variant>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"

namespace annulus::sim {

/// What happens to the frames that a bus receives; probabilities per frame.
struct CanFrameFaults {
  std::uint64_t seed = 1;
  double lose = 0.0;
  double repeat = 0.0;    ///< Comes again after 1 … displace_by more frames.
  double displace = 0.0;  ///< Comes after 1 … displace_by frames that were later.
  std::size_t displace_by = 4;
};

/// A bus that goes wrong by plan: the same seed and the same calls give the same faults. Passes on what no fault
/// touches. Times are the host's clock. Thread-bound. Borrows bus and clock.
class FaultyCanBus final : public CanBus {
 public:
  FaultyCanBus(CanBus& bus, Clock& clock, CanFrameFaults faults = {});

  /// From now on.
  void SetFrameFaults(CanFrameFaults faults);
  /// Sends fail this way in the time given.
  void RefuseSendsBetween(std::chrono::nanoseconds from, std::chrono::nanoseconds to, CanFault fault);
  /// The interface is down (kDown) or removed (kGone) in the time given; it stays unusable until reopened after.
  void BreakBetween(std::chrono::nanoseconds from, std::chrono::nanoseconds to, CanFault fault);
  /// The controller says this at a time.
  void ReportAt(std::chrono::nanoseconds time, const CanReport& report);
  /// This frame comes at a time.
  void FrameAt(std::chrono::nanoseconds time, const CanFrame& frame);
  /// The controller says this every `period` in the time given.
  void ReportBetween(std::chrono::nanoseconds from, std::chrono::nanoseconds to, std::chrono::nanoseconds period,
                     const CanReport& report);
  /// What was to last beyond `time` ends then: refused sends, a broken interface, floods, reports.
  void EndBy(std::chrono::nanoseconds time);
  /// Told before every call.
  void OnCall(std::function<void()> hook) { hook_ = std::move(hook); }
  /// This frame comes every `period` in the time given.
  void FloodBetween(std::chrono::nanoseconds from, std::chrono::nanoseconds to, std::chrono::nanoseconds period,
                    const CanFrame& frame);
  /// The next frame with this identifier is lost.
  void LoseNextOf(std::uint32_t id) { lose_next_of_ = id; }
  /// The next frames are lost in the receive queue, which counts them.
  void OverflowBy(std::size_t frames) { overflowing_ += frames; }
  /// What ReadLink says of restarts.
  void PretendRestartMs(std::uint32_t restart_ms) { restart_ms_ = restart_ms; }

  struct Log {
    std::uint64_t lost = 0;
    std::uint64_t repeated = 0;
    std::uint64_t displaced = 0;
    std::uint64_t overflowed = 0;
    std::uint64_t refused_sends = 0;
    std::uint64_t reopened = 0;
    std::vector<std::chrono::nanoseconds> restarts;
    std::vector<CanFrame> sent;  ///< All that was asked to be sent and was not refused.
  };
  [[nodiscard]] const Log& log() const { return log_; }

  CanResult<CanLink> ReadLink() override;
  CanResult<void> Send(const CanFrame& frame) override;
  CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t overflows() const override { return bus_.overflows() + log_.overflowed; }
  CanResult<void> Reopen() override;
  CanResult<void> Restart() override;

 private:
  struct Window {
    std::chrono::nanoseconds from{0};
    std::chrono::nanoseconds to{0};
    CanFault fault = CanFault::kError;
    [[nodiscard]] bool Holds(std::chrono::nanoseconds time) const { return time >= from && time < to; }
  };
  struct Flood {
    std::chrono::nanoseconds next{0};
    std::chrono::nanoseconds to{0};
    std::chrono::nanoseconds period{0};
    std::variant<CanFrame, CanReport> what;
  };
  struct Held {
    std::size_t frames_to_pass = 0;
    std::chrono::nanoseconds latest{0};  ///< Comes then though too few frames have passed.
    CanReception reception;
  };

  [[nodiscard]] std::optional<CanFault> Broken();
  void Tell() const {
    if (hook_) hook_();
  }
  std::optional<CanReception> TakeScheduled(std::chrono::nanoseconds now);
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextScheduled() const;
  /// Lets one frame through the faults; what comes out now stands in ready_.
  void Pass(const CanReception& reception);
  /// Moves what has waited long enough to ready_.
  void ReleaseHeld();

  CanBus& bus_;
  Clock& clock_;
  CanFrameFaults faults_;
  std::mt19937_64 random_;
  std::vector<Window> refusals_;
  std::optional<Window> broken_;
  std::multimap<std::chrono::nanoseconds, CanReception> scheduled_;
  std::vector<Flood> floods_;
  std::deque<Held> held_;
  std::deque<CanReception> ready_;
  std::size_t overflowing_ = 0;
  std::optional<std::uint32_t> lose_next_of_;
  std::optional<std::uint32_t> restart_ms_;
  Log log_;
  std::function<void()> hook_;
};

}  // namespace annulus::sim
