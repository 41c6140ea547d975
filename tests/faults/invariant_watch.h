#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/scanner.h"
#include "sim/booth.h"

namespace annulus::faults {

/// What people do, without which the booth neither leaves SAFE or FAULT nor moves.
enum class HumanAct { kReset, kAcknowledge, kHome, kStart, kJog };

/// Watches a simulated booth while the program runs on it, and keeps what breaks an invariant of the state machine:
///
///     I1  motion starts only in HOMING, SCANNING, JOG, or by an order that was on the wire when they ended
///     I2  chain open: enable, quick stop and emitters are off after the tick that could see it
///     I3  SAFE and FAULT are left only after a reset or an acknowledgement by a person; leaving them moves nothing
///     I4  an order to move follows a good answer of the drive within 100 ms
///     I5  as many scans as starts, at most
///     I6  the first cause stays the first until it is ended
///     I7  no state but SAFE, IDLE and FAULT lasts longer than its deadline
///     I9  motion starts only after a person's order (home, start, jog)
///     R0  the carriage stays within its travel; every cause has a text and an advice
///
/// It goes by the public status, by the logs of chain and drive and the true motion, never by private state. I8 and I10
/// are of the recording: see judge.h. Borrows all. Thread-bound.
class InvariantWatch {
 public:
  InvariantWatch(sim::BoothDevices& booth, const Clock& clock) : booth_(booth), clock_(clock) {}

  /// The program that is watched from now on; null: none runs.
  void Watch(const Scanner* scanner);
  void Note(HumanAct act);
  /// The program was stopped, or time passed without it: deadlines do not count over it.
  void Interrupted() { entered_ = clock_.Now(); }
  /// Before a request of the program goes out to the drive, and when a good answer is there.
  void BeforeRequest() { Look(); }
  void GoodAnswer() { last_answer_ = clock_.Now(); }
  /// Before and after the program's control tick.
  void BeforeTick() { Look(); }
  void AfterTick();
  /// Instead of AfterTick when the program makes none.
  void WithoutTick() { JudgePlace(); }

  struct StateAt {
    std::chrono::nanoseconds time{0};
    ScanState state = ScanState::kSafe;
  };
  /// Every change of state that was seen; the first is SAFE.
  [[nodiscard]] const std::vector<StateAt>& states() const { return states_; }
  /// When the state was first `state` at or after `time`.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> When(ScanState state, std::chrono::nanoseconds time) const;
  /// The state just before a time.
  [[nodiscard]] ScanState StateBefore(std::chrono::nanoseconds time) const;
  /// Causes as they were shown first, in order; a cause that is ended and comes again is shown again.
  [[nodiscard]] const std::vector<ScanCause>& shown() const { return shown_; }
  /// The chip took an order to an output, or refused it: then only the hardware can act, and is judged.
  void LinesTaken(bool taken) { lines_taken_ = taken; }
  /// Until when the machine was last seen to move or to have its brake open.
  [[nodiscard]] std::chrono::nanoseconds unsafe_until() const { return unsafe_until_; }
  [[nodiscard]] const std::vector<std::string>& violations() const { return violations_; }
  [[nodiscard]] std::string Text() const;

 private:
  void Look();
  void OnChange(ScanState from, const ScannerStatus& status);
  void JudgeMotion();
  void JudgeCauses(const ScannerStatus& status);
  void JudgeDeadline();
  void JudgePlace();
  void Violated(const std::string& what);
  [[nodiscard]] static bool Moves(ScanState state);

  sim::BoothDevices& booth_;
  const Clock& clock_;
  const Scanner* scanner_ = nullptr;
  std::vector<StateAt> states_;
  ScanState state_ = ScanState::kSafe;
  std::chrono::nanoseconds entered_{0};
  std::chrono::nanoseconds moved_until_{-std::chrono::hours(1)};  ///< Last seen in a state that may move.
  std::chrono::nanoseconds last_answer_{0};
  std::chrono::nanoseconds last_tick_{0};
  std::chrono::nanoseconds last_jog_{-std::chrono::hours(1)};
  std::optional<CauseCode> first_cause_;
  std::vector<ScanCause> shown_;
  std::chrono::nanoseconds unsafe_until_{0};
  std::uint64_t version_ = 0;
  std::size_t motions_ = 0;  ///< Of the drive's log, judged.
  std::uint64_t starts_ = 0;
  std::uint64_t scans_ = 0;
  bool lines_taken_ = true;
  bool reset_pressed_ = false;
  bool acknowledged_ = false;
  bool ordered_ = false;  ///< Home, start or jog since the last rest.
  std::vector<std::string> violations_;
};

}  // namespace annulus::faults
