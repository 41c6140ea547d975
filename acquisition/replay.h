#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/recording.h"
#include "acquisition/scan_sink.h"
#include "base/clock.h"
#include "base/progress.h"
#include "base/result.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// Where a replay is not what was recorded.
struct ReplayDifference {
  std::optional<std::uint64_t> level;  ///< Number of the level in the recording, 0 first.
  std::uint32_t index = 0;             ///< Its index in its sweep.
  std::uint16_t sweep = 0;
  std::optional<std::size_t> sensor;
  std::string field;     ///< "range_mm", "time_ns", "call NextLevel", "lost_frames"
  std::string recorded;  ///< As text; numbers with all their digits.
  std::string replayed;

  /// One line: where, and both values.
  [[nodiscard]] std::string Text() const;
};

/// Something that a replay brings about. At most one of the members is there, besides `time`.
struct ReplayStep {
  std::chrono::nanoseconds time{0};  ///< On the recorded host's clock.
  std::optional<ScanLevel> level;
  std::optional<AxisPoint> axis;
  std::optional<ReplayDifference> difference;  ///< A call of a driver ended otherwise than recorded.
};

struct ReplayOptions {
  /// Put something (faults) between the ring's driver and the recorded ports or buses: called once when a replay
  /// begins, and again after a Seek back. What is returned is borrowed until the replay goes; of the same number and in
  /// the same order. Empty: nothing.
  std::function<std::vector<UsbPort*>(const std::vector<UsbPort*>&, Clock&)> wrap_usb;
  std::function<std::vector<CanBus*>(const std::vector<CanBus*>&, Clock&)> wrap_can;
  /// Told when the recorded scan begins. May be empty.
  std::function<void()> on_begin;
  /// Told every level as it comes out. May be empty.
  std::function<void(const ScanLevel&)> on_level;
};

/// Runs a recorded scan again: the recorded bytes go through the ring's own driver and through the pipeline of RunScan
/// (LevelPipeline), in the order and at the times of the recorded calls, in virtual time. There is no axis: where the
/// carriage was is decoded from the recorded registers, and nothing here could move anything. Without faults the same
/// levels come out to the last bit. Thread-bound.
class Replay {
 public:
  /// Opens the ring that was recorded, as it was opened then. `raw`: as Recording::raw; it is copied. Fails if it holds
  /// no scan, or is of a newer format.
  static Result<Replay> Open(std::span<const RawRecord> raw, ReplayOptions options = {});
  Replay(Replay&&) noexcept;
  Replay& operator=(Replay&&) noexcept;
  ~Replay();

  /// What comes next; nothing at the end.
  Result<std::optional<ReplayStep>> Next();
  /// Goes to where the next level that Next gives is number `level` of the scan, 0 first; what lies between is
  /// replayed, but not given. Goes back by beginning anew. Fails if there are not so many.
  Status Seek(std::uint64_t level);

  /// Levels that came out so far.
  [[nodiscard]] std::uint64_t levels() const;
  /// Of all records: how much is done, 0 … 1.
  [[nodiscard]] double done() const;
  /// Records that are of a kind that this program does not know; they are passed over.
  [[nodiscard]] std::uint64_t unknown_records() const;
  /// The ring's counters as they were when it was last stopped.
  [[nodiscard]] const RingCounters& counters() const;

 private:
  struct State;
  explicit Replay(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

/// How a replay compares with what was recorded.
struct ReplayComparison {
  std::uint64_t recorded_levels = 0;
  std::uint64_t replayed_levels = 0;
  std::uint64_t identical_levels = 0;  ///< Equal to the last bit.
  std::uint64_t axis_points = 0;       ///< Compared.
  std::uint64_t differing = 0;         ///< Levels, axis points and calls that are not as recorded.
  double worst_range_mm = 0.0;         ///< Largest difference of a range that both have.
  double worst_z_mm = 0.0;             ///< Of a height.
  std::uint64_t unknown_records = 0;
  /// Where it differs first; nothing: identical.
  std::optional<ReplayDifference> first;

  [[nodiscard]] bool identical() const { return !first.has_value(); }
  /// One line for people.
  [[nodiscard]] std::string BriefReport() const;
};

/// Compares what a replay gives, step by step, with the recorded levels and axis points. An unfinished recording may
/// end before its raw bytes do: what comes after its end is not counted. Borrows the recording.
class ReplayComparer {
 public:
  explicit ReplayComparer(const Recording& recording);

  /// Skips the recorded levels before this one and the axis points: after a Seek.
  void StartAt(std::uint64_t level);
  void Take(const ReplayStep& step);
  /// At the end: what is left of the recording was not replayed.
  void Finish();
  [[nodiscard]] const ReplayComparison& comparison() const { return comparison_; }

 private:
  void TakeLevel(const ScanLevel& level);
  void TakeAxis(const AxisPoint& point);
  void Differ(ReplayDifference difference);
  void CompareReadings(const ScanLevel& recorded, const ScanLevel& replayed, ReplayDifference where);

  const Recording& recording_;
  std::size_t next_level_ = 0;
  std::size_t next_axis_ = 0;
  bool compare_axis_ = true;
  ReplayComparison comparison_;
};

/// Replays a recording as fast as it goes and compares all of it. The comparison that was made so far is lost on a stop
/// request.
Result<ReplayComparison> CompareWithRecorded(const Recording& recording, ReplayOptions options,
                                             const TaskContext& task);

}  // namespace annulus
