#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan_cause.h"
#include "tests/faults/fault_rig.h"

namespace annulus::faults {

/// What a run must have come to, beyond what every run must (R0).
struct Expected {
  std::vector<CauseCode> causes;  ///< The first one shown is one of these; empty: none is shown.
  enum class Next { kScan, kNone };
  Next next = Next::kScan;  ///< kNone: the damage stays, nothing can be scanned.
};

/// R0 of the fault matrix, by what is seen from outside: the invariants held at every tick; the axis rests, braked,
/// within its travel; one cause first, with text and advice, and the expected one; the recording is readable and has
/// every level that was taken; no transfer is in flight; the next scan passes. Each failure is a line of the answer;
/// empty: all is as it must be. Ends the fault's consequences and takes a scan, so the machine must be whole again.
[[nodiscard]] std::string JudgeRun(FaultRig& rig, const Expected& expected);

/// The parts of it.
[[nodiscard]] std::string JudgeRest(FaultRig& rig);
[[nodiscard]] std::string JudgeCause(const FaultRig& rig, const Expected& expected);
/// I8: every point of the axis' track is where the carriage really was; I10: a scan that is said to be complete has all
/// levels; and no level that was taken is missing.
[[nodiscard]] std::string JudgeRecording(FaultRig& rig, const std::string& path);

/// From `fault` until machine and brake rested for good, as of the ticks.
[[nodiscard]] std::chrono::nanoseconds TimeToSafe(FaultRig& rig, std::chrono::nanoseconds fault);
/// When an output or signal first had a level at or after a time.
[[nodiscard]] std::optional<std::chrono::nanoseconds> WhenSignal(FaultRig& rig, sim::ChainSignal signal, bool level,
                                                                 std::chrono::nanoseconds from);

/// Open file descriptors and threads of this process.
struct ProcessUse {
  std::size_t descriptors = 0;
  std::size_t threads = 0;
  bool operator==(const ProcessUse&) const = default;
};
[[nodiscard]] ProcessUse UseOfProcess();

/// For the matrix that the program prints at its end.
void ReportTimeToSafe(std::chrono::nanoseconds time);
void ReportNote(const std::string& note);

}  // namespace annulus::faults
