#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "acquisition/recording.h"
#include "tests/faults/judge.h"

namespace annulus::faults {

/// Of the rig's plan: 30 levels/s.
inline constexpr std::chrono::nanoseconds kLevelPeriod{33'333'334};
inline constexpr std::chrono::milliseconds kControlTick{10};

[[nodiscard]] bool IsStopped(const FaultRig& rig);
/// The operator takes a scan until a fault of the plan has stopped it. False: none did.
[[nodiscard]] bool ScanIntoFault(FaultRig& rig);
/// When the program ended the scan: the first state that does not move at or after the fault's beginning.
[[nodiscard]] std::chrono::nanoseconds WhenStopped(FaultRig& rig);

/// What this check of the last arming says; empty: nothing against it.
[[nodiscard]] std::string RefusalOf(const FaultRig& rig, const std::string& check);

/// The longest of what is reported.
class Longest {
 public:
  /// Also tells the matrix.
  void Note(std::chrono::nanoseconds time);
  [[nodiscard]] std::chrono::nanoseconds time() const { return time_; }

 private:
  std::chrono::nanoseconds time_{0};
};

// What rows have in common. Each failure is a line of the answer; empty: all is as it must be.

/// The fault stops the scan: at rest 500 ms after that at the latest, one of these causes alone, and all of R0.
[[nodiscard]] std::string StopsScan(FaultRig& rig, const std::vector<CauseCode>& causes, Longest& safe);
/// The scan goes through: every level, no cause, and all of R0.
[[nodiscard]] std::string BearsScan(FaultRig& rig);
/// Arming is refused by this check, whose text contains `text`; then, when the plan's faults have ended, all of R0.
[[nodiscard]] std::string RefusesToArm(FaultRig& rig, const std::string& check, const std::string& text);

/// The rig's first scan, as recorded. A test that asks for one that cannot be read fails.
[[nodiscard]] Recording RecordedScan(FaultRig& rig);
/// Readings that are numbers and further than `within_mm` from `range_mm`.
[[nodiscard]] std::size_t FalseRanges(const Recording& recording, double range_mm, double within_mm);

}  // namespace annulus::faults
