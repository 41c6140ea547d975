#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan_cause.h"
#include "base/result.h"

namespace annulus {

enum class ScanState {
  kSafe,  ///< Power-up; the chain is open or not yet reset: drive disabled, brake on, emitters off.
  kIdle,  ///< Chain closed, drive disabled.
  kHoming,
  kArmed,  ///< Homed, checks passed, disk reserved, customer bound; for kArmedFor.
  kScanning,
  kStopping,  ///< Coming to rest; then kIdle, or kFault.
  kFault,     ///< Latched cause; drive disabled.
  kJog,       ///< Technician, hold to run, at service speed: a part of kIdle that may move.
};
inline constexpr std::size_t kScanStates = 8;
[[nodiscard]] const char* ScanStateText(ScanState state);

enum class ScanEventKind {
  kChainOpened,  ///< E-stop, door, limit, or a fault of the chain: the hardware has acted.
  kResetTaken,   ///< The chain is closed and somebody has pressed reset: the interlock let the outputs free.
  kHomeOrdered,
  kHomed,  ///< Home found, axis at rest and disabled again.
  kHomingFailed,
  kArmed,      ///< The order to arm, all checks passed.
  kStarted,    ///< Start, with the version of the state that it was given for.
  kLastLevel,  ///< The last level of the plan is written and synced.
  kCancelled,
  kArmExpired,    ///< Armed for too long.
  kFaulted,       ///< A device, link, limit, overrun or the storage failed.
  kStopped,       ///< At rest, disabled, brake read back.
  kStopLate,      ///< Not stopped kStopLateAfter after the stop began.
  kStopOverdue,   ///< Not stopped kStopOverdueAfter after the stop began.
  kAcknowledged,  ///< By somebody who may, and the cause is gone.
  kJogOrdered,
  kJogReleased,  ///< Or no beat for kJogBeat.
  kAwoke,        ///< The process has just started, or stood still for longer than the watchdog waits.
};
inline constexpr std::size_t kScanEventKinds = 18;
[[nodiscard]] const char* ScanEventText(ScanEventKind kind);
/// An order as it is given, for messages: "home the axis". Of what is no order, as ScanEventText.
[[nodiscard]] const char* ScanOrderText(ScanEventKind kind);

/// Times of the machine, on the host's clock.
namespace scan_time {
inline constexpr std::chrono::milliseconds kTick{10};               ///< The control tick.
inline constexpr std::chrono::milliseconds kStopLateAfter{300};     ///< Then the quick-stop line demands it.
inline constexpr std::chrono::milliseconds kStopOverdueAfter{500};  ///< Then enable is dropped.
inline constexpr std::chrono::seconds kArmedFor{60};
inline constexpr std::chrono::seconds kStartAgreed{10};  ///< So long whoever pressed the start key awaits the start.
inline constexpr std::chrono::seconds kHomingFor{95};
inline constexpr std::chrono::milliseconds kJogBeat{100};
}  // namespace scan_time

/// Something that happened. What a kind does not need is ignored.
struct ScanEvent {
  ScanEventKind kind = ScanEventKind::kAwoke;
  std::chrono::nanoseconds time{0};  ///< Host clock; never before that of the event before.
  ScanCause cause;            ///< kChainOpened, kHomingFailed, kFaulted, kStopOverdue; kAwoke: kInternal is none.
  std::uint64_t version = 0;  ///< kStarted: that of the state in which the order was given.
  std::chrono::nanoseconds longest{0};    ///< kStarted: the scan must be over after it.
  CauseRole role = CauseRole::kOperator;  ///< kAcknowledged: of who does it.
};

/// The levels that the machine wants on the interlock's outputs. All false is safe.
struct LineOrders {
  bool enable = false;
  bool quick_stop = false;  ///< True: run.
  bool emitters = false;
  bool lamp_ready = false;
  bool lamp_running = false;
  bool lamp_fault = false;

  bool operator==(const LineOrders&) const = default;
};

/// The state of the booth: who may do what, and what follows. A pure value: no device, no clock, no thread.
///
///     event                  | SAFE  | IDLE   | HOMING   | ARMED    | SCANNING | STOPPING | FAULT | JOG
///     -----------------------|-------|--------|----------|----------|----------|----------|-------|---------
///     chain opened           | SAFE  | SAFE   | SAFE     | SAFE     | SAFE     | SAFE     | SAFE  | SAFE
///     reset taken            | IDLE* | -      | -        | -        | -        | -        | -     | -
///     home ordered           | no    | HOMING | no       | no       | no       | no       | no    | no
///     homed                  | -     | -      | IDLE     | -        | -        | -        | -     | -
///     homing failed          | -     | -      | STOPPING | -        | -        | -        | -     | -
///     armed                  | no    | ARMED  | no       | ARMED    | no       | no       | no    | no
///     started                | no    | no     | no       | SCANNING | no       | no       | no    | no
///     last level             | -     | -      | -        | -        | STOPPING | -        | -     | -
///     cancelled              | -     | -      | STOPPING | IDLE     | STOPPING | -        | -     | STOPPING
///     arm expired            | -     | -      | -        | IDLE     | -        | -        | -     | -
///     faulted                | SAFE+ | FAULT  | STOPPING | FAULT    | STOPPING | STOPPING | FAULT | STOPPING
///     stopped                | -     | -      | -        | -        | -        | IDLE*    | -     | -
///     stop late              | -     | -      | -        | -        | -        | STOPPING | -     | -
///     stop overdue           | -     | -      | -        | -        | -        | SAFE     | -     | -
///     acknowledged           | no    | no     | no       | no       | no       | no       | IDLE  | no
///     jog ordered            | no    | JOG    | no       | no       | no       | no       | no    | JOG
///     jog released           | -     | -      | -        | -        | -        | -        | -     | STOPPING
///     awoke                  | SAFE  | SAFE   | SAFE     | SAFE     | SAFE     | SAFE     | SAFE  | SAFE
///
/// "no" is refused with a message, "-" means nothing in this state. *: FAULT if a cause is latched. +: the cause is
/// noted. A cause is latched until it is acknowledged; what the chain demanded (kChainOpen) only until the reset. The
/// first cause stays the first. ARMED on "armed": the checks were made again, the time starts anew, and so does the
/// version. "faulted" and "homing failed" for kChainOpen mean "chain opened", except where the table says "-".
///
/// `homed` falls with SAFE, with HOMING, and with every cause that says so.
class ScanMachine {
 public:
  [[nodiscard]] ScanState state() const { return state_; }
  /// Rises with every change of state and every arming: a start given for an older version is refused.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] bool homed() const { return homed_; }
  /// Latched causes, the first one first; of repeated ones only the first is kept.
  [[nodiscard]] const std::vector<ScanCause>& causes() const { return causes_; }
  /// A stop that demands the quick-stop line.
  [[nodiscard]] bool quick_stop_demanded() const { return quick_stop_; }
  /// When this state was entered, host clock.
  [[nodiscard]] std::chrono::nanoseconds since() const { return since_; }
  /// Scans that were started.
  [[nodiscard]] std::uint64_t scans() const { return scans_; }

  /// Takes an event. An Error if it is refused: what was asked, in which state, what to do. Nothing has changed then.
  Status Handle(const ScanEvent& event);
  /// Whether an order of this kind would be taken now; as Handle, without doing it.
  [[nodiscard]] Status MayOrder(ScanEventKind kind) const;
  /// The event that the time brings, once it has come: arm expired, stop late, stop overdue, a state that lasts too
  /// long. To be asked every tick, until it says nothing.
  [[nodiscard]] std::optional<ScanEvent> Due(std::chrono::nanoseconds now) const;
  /// A jog is still wanted.
  void JogBeat(std::chrono::nanoseconds now) { jog_beat_ = now; }

  /// Whether an order to move may be given to the axis.
  [[nodiscard]] bool may_move() const {
    return state_ == ScanState::kHoming || state_ == ScanState::kScanning || state_ == ScanState::kJog;
  }
  [[nodiscard]] LineOrders Lines() const;

 private:
  void Enter(ScanState state, std::chrono::nanoseconds time);
  void Latch(const ScanCause& cause);
  /// Into kStopping, or from there on; which way the axis is stopped follows from the cause.
  void Stop(const ScanEvent& event);
  [[nodiscard]] bool Latched() const;

  ScanState state_ = ScanState::kSafe;
  std::uint64_t version_ = 1;
  bool homed_ = false;
  std::vector<ScanCause> causes_;
  bool quick_stop_ = false;
  std::chrono::nanoseconds since_{0};
  std::chrono::nanoseconds longest_{0};  ///< Of kScanning.
  std::chrono::nanoseconds jog_beat_{0};
  std::uint64_t scans_ = 0;
};

}  // namespace annulus
