#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "acquisition/scan_plan.h"
#include "acquisition/scan_sink.h"
#include "base/clock.h"
#include "base/progress.h"
#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// How a scan went.
struct ScanSummary {
  bool cancelled = false;  ///< Stopped from outside; what was taken is kept.
  std::uint32_t planned_levels = 0;
  std::uint32_t levels = 0;           ///< Handed to the sink.
  std::uint32_t missing_levels = 0;   ///< Planned levels of finished sweeps that no SYNC fell on.
  std::uint32_t sweeps = 0;           ///< Finished.
  std::chrono::nanoseconds start{0};  ///< Host clock of the first level.
  std::chrono::nanoseconds end{0};    ///< Host clock when the axis was disabled.
  std::uint64_t returns = 0;          ///< Readings that are a range.
  std::uint64_t no_returns = 0;       ///< Readings that are none.
  RingCounters ring;                  ///< Lost and rejected frames.
  double worst_clock_bound_us = 0.0;  ///< Largest bound of a board's or the drive's clock, us.
  /// With reference sensors: levels of which their board said something, and why it ended ("": it did not).
  std::optional<std::uint32_t> reference_levels{};
  std::string reference_trouble{};

  /// One line for people.
  [[nodiscard]] std::string BriefReport() const;
};

/// Runs a validated plan:
///
///     check ring -> enable -> home -> for each sweep: go to its start, wait for the right SYNC, sweep -> disable
///
/// The ring must be idle and the axis disabled; both are so again afterwards, whatever happens. Each board's stamp is
/// brought to the host's clock and each reading gets the carriage's height at its own time. What becomes of a reference
/// board is noted as an event, and the scan goes on. A stop request is a
/// controlled stop: axis at rest and disabled, data kept, summary.cancelled. A device's or the sink's error is a
/// quick stop; the Error says what to do. Fails before anything moves if the plan is not valid as it is.
Result<ScanSummary> RunScan(RangeRing& ring, ScanAxis& axis, const ScanPlan& plan, ScanSink& sink, Clock& clock,
                            const TaskContext& task);

/// The fast coarse sweep from the axis' top by which FindSubjectTop searches.
[[nodiscard]] ScanPlan SearchPlan(const AxisLimits& limits);

/// Height of the highest thing in the ring, found by a fast coarse sweep from the axis' top (5 mm per level). Same
/// preconditions and stops as RunScan. Fails when nothing is found or on a stop request.
Result<Millimetres> FindSubjectTop(RangeRing& ring, ScanAxis& axis, Clock& clock, const TaskContext& task);

}  // namespace annulus
