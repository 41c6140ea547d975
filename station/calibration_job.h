#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration_file.h"
#include "acquisition/scan.h"
#include "base/progress.h"
#include "base/result.h"
#include "fitting/calibrate_ring.h"
#include "station/calibration_plan.h"
#include "station/calibration_report.h"

namespace annulus {

/// A calibration to be made of scans that were taken.
struct CalibrationJob {
  CalibrationPlan plan;
  std::vector<Scan> scans;                  ///< One per placement of the plan.
  std::optional<CalibrationFile> previous;  ///< In force until now: as found, history, and what a lone board joins.
  std::optional<std::uint32_t> board;       ///< Serial of the only board that is calibrated; needs `previous`.
  CalibrationLimits limits;
};

/// What came of it.
struct CalibrationOutcome {
  RingSolution solution;
  CalibrationFile file;  ///< Not written yet: certificate and hash are still empty.
  CalibrationReport report;
  bool passed = false;  ///< All limits kept and nothing found that forbids its use.
};

/// Readings of a recording as the solver takes them; turn and temperatures as the placement says.
[[nodiscard]] TargetScan TargetScanOf(const Scan& scan, const PlannedPlacement& placement, const std::string& name,
                                      double ambient_c);

/// The calibration that a solve starts from, at the mean temperature of the ring in these scans.
[[nodiscard]] RingCalibration AtScansTemperature(const RingCalibration& start, const std::vector<TargetScan>& scans);

/// Solves, verifies, judges. Fails if scans are of different rings, or cannot be solved.
[[nodiscard]] Result<CalibrationOutcome> Calibrate(const CalibrationJob& job, const TaskContext& task);

}  // namespace annulus
