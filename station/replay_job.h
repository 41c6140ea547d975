#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/replay.h"
#include "base/clock.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

struct ReplayRequest {
  std::string recording;
  double speed = 0.0;      ///< Times real time; 0: as fast as it goes.
  std::string faults;      ///< A fault plan to put between the recorded buses and the drivers; "" is none.
  std::uint64_t from = 0;  ///< First level that is given, 0 first.
  std::uint64_t to = std::numeric_limits<std::uint64_t>::max();  ///< Last one.
  const KeySource* keys = nullptr;                               ///< Of sealed recordings. Borrowed.
  std::string out;  ///< Recording to write of what is replayed; "" is none.
  /// Told every level with its number, before it counts; false ends the replay there. May be empty.
  std::function<bool(std::uint64_t number, const ScanLevel& level)> on_level;
};

struct ReplayOutcome {
  ReplayComparison comparison;
  bool whole = false;                  ///< From the first to the last level.
  std::vector<std::string> faults;     ///< That happened, in the order of time.
  std::vector<std::string> untouched;  ///< Of the plan: what a replay passes over, since it is not of the buses.
  double scan_s = 0.0;                 ///< Recorded time that was replayed, s.
  double replay_s = 0.0;               ///< What that took, s.
};

/// Replays a recording and compares it with itself. Nothing but files is opened: no device, simulated or real. `clock`
/// is the host's; it paces and times. Fails if the recording has no raw bytes (imported, or of an earlier version), on
/// a stop request, and if `out` can not be written.
Result<ReplayOutcome> RunReplayJob(const ReplayRequest& request, Storage& storage, Clock& clock,
                                   const TaskContext& task);

}  // namespace annulus
