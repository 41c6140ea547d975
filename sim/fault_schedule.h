#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/fault_plan.h"

namespace annulus::sim {

/// A call at a seam.
struct FaultCall {
  FaultTarget target = FaultTarget::kHost;
  static constexpr std::size_t kAnywhere = std::numeric_limits<std::size_t>::max();
  std::size_t where = kAnywhere;  ///< Board or bus.
  bool submits = false;           ///< USB: a transfer is submitted.
};

/// Something that was done to the booth.
struct FaultEvent {
  std::chrono::nanoseconds time{0};  ///< Host clock.
  std::size_t fault = 0;             ///< Number in the plan.
  bool begins = true;                ///< False: it ended.
  std::string text;                  ///< As FaultText.

  bool operator==(const FaultEvent&) const = default;
};

/// Finds out when the faults of a plan begin and end. Knows nothing of what they do. Thread-bound. Borrows the plan.
class FaultSchedule {
 public:
  FaultSchedule(const FaultPlan& plan, std::chrono::nanoseconds start);

  /// The booth is in this state; may be said again and again.
  void NoteState(const std::string& state, std::chrono::nanoseconds now);
  /// Level `number` of a scan has been taken.
  void NoteLevel(std::uint64_t number, std::chrono::nanoseconds now);
  /// A call is about to be made.
  void NoteCall(const FaultCall& call, std::chrono::nanoseconds now);
  /// This fault has begun by itself.
  void NoteBegun(std::size_t fault, std::chrono::nanoseconds now);

  /// What nobody was told of yet does not happen any more, nor is it waited for. Returns their numbers.
  std::vector<std::size_t> Disarm();

  /// What is to be done now.
  struct Step {
    std::size_t fault = 0;
    bool begins = true;
    std::chrono::nanoseconds time{0};  ///< When; of what can be told ahead it may still come.
    /// Of a beginning: when it ends, if that is known.
    std::chrono::nanoseconds to = std::chrono::nanoseconds::max();
  };
  /// In the order of time. Each is said once.
  [[nodiscard]] std::vector<Step> Take(std::chrono::nanoseconds now);

  /// What has happened, in the order of time.
  [[nodiscard]] const std::vector<FaultEvent>& log() const { return log_; }
  /// Every fault has begun, and those that end have ended, but for what was disarmed.
  [[nodiscard]] bool finished() const;

 private:
  struct Run {
    std::optional<std::chrono::nanoseconds> from;
    std::optional<std::chrono::nanoseconds> to;
    std::uint64_t calls = 0;
    bool told = false;
    bool begun = false;
    bool ended = false;
    bool disarmed = false;
  };
  [[nodiscard]] bool Ends(std::size_t fault) const { return plan_.faults[fault].lasting || plan_.faults[fault].until; }
  void Log(std::size_t fault, std::chrono::nanoseconds time, bool begins);

  const FaultPlan& plan_;
  std::chrono::nanoseconds start_;
  std::vector<Run> runs_;
  std::string state_;
  std::vector<FaultEvent> log_;
};

}  // namespace annulus::sim
