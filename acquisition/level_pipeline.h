#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "acquisition/level_stamper.h"
#include "acquisition/scan.h"
#include "acquisition/scan_plan.h"
#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// From what the devices say to the levels of a plan: each reading gets its height (LevelStamper), each level its place
/// in the plan. Pure: no device, no clock. The same values in the same order give the same levels to the last bit, in a
/// scan as in its replay. Thread-bound.
class LevelPipeline {
 public:
  /// Borrows the list of boards. The plan must be valid.
  LevelPipeline(const std::vector<RingBoard>& boards, ScanPlan plan) : stamper_(boards), plan_(std::move(plan)) {}

  /// Learns a board's clock (LevelStamper).
  Status AddBoardClock(std::size_t board, const ClockExchange& exchange) {
    return stamper_.AddBoardClock(board, exchange);
  }
  /// Learns the drive's clock and the carriage's place. The host's time of the position if it is to be recorded: while
  /// levels are collected. Only for fresh positions.
  Result<std::optional<std::chrono::nanoseconds>> AddPosition(const AxisPosition& position);
  /// A sweep of the plan begins: from here on levels are collected.
  void BeginSweep(std::uint32_t sweep);
  /// It is over; levels whose height is not known yet are dropped.
  void EndSweep();
  /// Takes a level of the ring; it is dropped unless levels are collected.
  Status AddLevel(RingLevel level);
  /// The levels that are complete now and that the plan wants, in order.
  std::vector<ScanLevel> Take();

  [[nodiscard]] bool collecting() const { return collecting_; }
  /// Of the present sweep: levels that came out.
  [[nodiscard]] std::uint32_t sweep_levels() const { return sweep_levels_; }
  /// Of the present sweep: a level behind its last planned one was seen.
  [[nodiscard]] bool passed_end() const { return passed_end_; }
  /// Mean height of the present sweep's levels above their planned ones, mm; 0 without levels.
  [[nodiscard]] double mean_deviation_mm() const;
  /// Host time at which a board fired. Its clock must have been read.
  [[nodiscard]] std::chrono::nanoseconds HostTime(std::size_t board, std::chrono::nanoseconds device_time) const {
    return stamper_.HostTime(board, device_time);
  }
  /// Largest bound of all clocks, us. Every clock must have been read.
  [[nodiscard]] double WorstBound() const { return stamper_.WorstBound(); }

 private:
  /// Puts a level in its place in the plan; false: the plan does not want it.
  bool Place(ScanLevel& level);

  LevelStamper stamper_;
  ScanPlan plan_;
  bool collecting_ = false;
  std::uint32_t sweep_ = 0;
  std::int64_t last_index_ = -1;  ///< Of this sweep.
  std::uint32_t sweep_levels_ = 0;
  bool passed_end_ = false;
  double deviation_sum_ = 0.0;  ///< Of this sweep's levels from their planned heights, mm.
};

}  // namespace annulus
