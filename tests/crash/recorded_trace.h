#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/recording.h"
#include "acquisition/sealed_file.h"
#include "tests/support/crash_disk.h"

namespace annulus::test {

/// A defect put around a disk: a Storage that hands its calls on, wrongly. Null: none.
using Defect = std::function<std::unique_ptr<Storage>(Storage& below, CrashDisk& disk)>;

/// Whether a recording is encrypted on the disk.
enum class Sealing { kPlain, kSealed };

/// What to record.
struct TracePlan {
  std::uint32_t levels = 24;
  std::size_t sensors = 4;
  std::uint32_t levels_per_s = 24;
  std::uint32_t content = 0;          ///< Which of the scans that are alike but for what was measured.
  Sealing sealing = Sealing::kPlain;  ///< Sealed: the same bytes but for the file's id, which is random.
  bool finish = true;                 ///< Else the writer goes away after the last level.
  Defect below{};                     ///< Between the disk and what is believed of it.
  Defect above{};                     ///< Between the writer and what is believed of it.
  CrashDisk::Files existing{};        ///< On the disk before.
  std::uint64_t fail_call = 0;        ///< The call of the disk that fails (1 = the first); 0: none.
  DiskFault fault = DiskFault::kIoError;
};

/// A sync that the writer was told has succeeded.
struct Promise {
  std::size_t entries = 0;  ///< Length of the disk's journal when it returned.
  std::chrono::nanoseconds time{0};
  SyncCaller caller = SyncCaller::kWaits;
  std::uint64_t bytes = 0;  ///< Of the file, durable since.
};

/// A scan as it was recorded on a CrashDisk, and what its writer was told on the way.
struct Trace {
  Scan scan;                    ///< What was given to the writer (all of the plan's levels).
  std::vector<AxisPoint> axis;  ///< The same.
  std::vector<RecordedEvent> events;
  std::vector<RawRecord> raw;
  std::vector<SafetyLines> safety;
  std::string path;                 ///< The recording's name when it is finished.
  std::string temporary;            ///< Before.
  std::unique_ptr<CrashDisk> disk;  ///< With the journal.
  std::uint32_t levels_per_s = 0;

  std::optional<std::size_t> created;        ///< Length of the journal when Create returned.
  std::vector<std::size_t> level_entries;    ///< Length of the journal when each acknowledged level was.
  std::vector<std::uint64_t> level_ends;     ///< Bytes given to the file until then.
  std::optional<std::size_t> finished;       ///< Length of the journal when Finish returned success.
  std::vector<Promise> promises;             ///< Syncs, in order.
  std::uint64_t promises_after_failure = 0;  ///< Syncs that succeeded after one that had failed.
  std::optional<Error> failure;              ///< The writer's first.
  bool failure_repeated = true;              ///< Every call after it failed alike.

  [[nodiscard]] std::size_t acknowledged() const { return level_ends.size(); }
  /// Levels that the writer was promised to be durable at the cut.
  [[nodiscard]] std::size_t DurableLevels(const PowerCut& cut) const;
  /// Levels that were acknowledged at the cut, and the one being written.
  [[nodiscard]] std::size_t LevelsGiven(const PowerCut& cut) const;
};

/// Small synthetic levels at the plan's rate; before each an axis point and two raw records, at every fifth an event
/// and the safety lines.
Trace Record(const TracePlan& plan);

}  // namespace annulus::test
