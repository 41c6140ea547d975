#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/ring_calibration.h"
#include "fitting/calibrate_ring.h"
#include "station/calibration_plan.h"

namespace annulus {

/// How a placement was scanned, as seen right after it.
struct PlacementCheck {
  bool good = false;
  std::vector<std::string> problems;  ///< Each with what to do; empty if good.
  bool pose_known = false;            ///< Not of a board, nor of a target that was not found.
  double x_mm = 0.0, y_mm = 0.0;      ///< Where the middle of the target's axis is.
  double tilt_deg = 0.0;
  double noise_mm = 0.0;
  std::size_t readings = 0;

  /// One line: where it stood, and the noise.
  [[nodiscard]] std::string Text() const;
};

/// How the calibration stands after some placements.
struct CalibrationSoFar {
  bool solved = false;
  double rms_mm = 0.0;                                       ///< Of the bins' residuals after the solve.
  double expected_mm = 0.0;                                  ///< What noise alone would leave.
  double common_sigma_mm = 0.0;                              ///< sd of the radius common to all sensors at 450 mm.
  double lateral_sigma_deg = 0.0, vertical_sigma_deg = 0.0;  ///< Of a sensor's beam at 450 mm.

  [[nodiscard]] std::string Text() const;
};

/// Leads through a calibration, placement by placement: what to do, whether it was done well, how the result grows.
/// For the command line and the console alike; knows no devices. Thread-bound.
class CalibrationGuide {
 public:
  /// Seconds that each placement should take, the target's move included: ten of them and the solve fit into ten
  /// minutes.
  static constexpr double kStepBudget = 55.0;

  CalibrationGuide(CalibrationPlan plan, RingCalibration start) : plan_(std::move(plan)), start_(std::move(start)) {}

  [[nodiscard]] const CalibrationPlan& plan() const { return plan_; }
  [[nodiscard]] std::size_t steps() const { return plan_.placements.size(); }
  /// "placement 3 of 9: stand the cylinder …"
  [[nodiscard]] std::string Instruction(std::size_t step) const;
  /// Looks at the scan of a step: target found, where it was asked for, at rest, seen well.
  [[nodiscard]] PlacementCheck Check(std::size_t step, const TargetScan& scan) const;
  /// Solves what there is; with fewer than three placements nothing is solved yet.
  [[nodiscard]] CalibrationSoFar SolveSoFar(const std::vector<TargetScan>& scans, const TaskContext& task) const;

 private:
  CalibrationPlan plan_;
  RingCalibration start_;
};

}  // namespace annulus
