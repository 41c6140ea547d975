#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "acquisition/axis_track.h"
#include "acquisition/clock_sync.h"
#include "acquisition/scan.h"
#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// Gives every reading of a level the carriage's height at its own time: board clock → host clock → drive clock →
/// track. A level waits here until the track has passed it, so that heights are never extrapolated.
class LevelStamper {
 public:
  /// Borrows the list of boards.
  explicit LevelStamper(const std::vector<RingBoard>& boards) : boards_(boards), board_clocks_(boards.size()) {}

  /// Learns a board's clock. Index boards().size(): the reference board's; if that makes no sense, what the board says
  /// is used no more, and it is no failure.
  Status AddBoardClock(std::size_t board, const ClockExchange& exchange);
  /// Learns the drive's clock and the carriage's place. Only for fresh positions.
  Status AddPosition(const AxisPosition& position);
  /// Queues a level. Fails if a board's stamp cannot be: taken after it arrived, or more than a second before.
  Status AddLevel(RingLevel level);
  /// The levels whose heights are known now, in order. index and sweep are left to the caller.
  std::vector<ScanLevel> Take();
  /// Forgets the queued levels.
  void Drop() { waiting_.clear(); }

  /// Host time at which a board fired.
  [[nodiscard]] std::chrono::nanoseconds HostTime(std::size_t board, std::chrono::nanoseconds device_time) const {
    return board_clocks_[board].HostTime(device_time);
  }
  /// Host time of a position.
  [[nodiscard]] std::chrono::nanoseconds HostTime(const AxisPosition& position) const {
    return drive_clock_.HostTime(position.time.device_time);
  }
  /// Largest bound of all clocks, us. Every clock must have been read.
  [[nodiscard]] double WorstBound() const;

 private:
  [[nodiscard]] bool Passed(const RingLevel& level) const;
  [[nodiscard]] ScanLevel Stamp(const RingLevel& level) const;
  /// Puts the reference board's readings, with their time, into the level.
  void StampReference(const RingLevel& raw, ScanLevel& level) const;

  const std::vector<RingBoard>& boards_;
  std::vector<ClockSync> board_clocks_;
  std::optional<ClockSync> reference_clock_ = ClockSync();  ///< Nothing: it cannot be.
  ClockSync drive_clock_;
  AxisTrack track_;
  std::deque<RingLevel> waiting_;
};

/// Height of a level as a whole: the mean over its readings, mm.
[[nodiscard]] double MeanHeight(const ScanLevel& level);

}  // namespace annulus
