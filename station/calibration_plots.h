#pragma once

#include <limits>
#include <string>
#include <vector>

#include "fitting/calibrate_ring.h"
#include "station/calibration_report.h"
#include "station/calibration_verdict.h"
#include "station/figure.h"

namespace annulus {

/// Width of all plots, mm: a page's text.
inline constexpr double kPlotWidth = 178.0;

/// Radial errors around the ring at 450 mm: above, before and after at one scale; below, what is left with its 95 %
/// bars and the limit. Boards of 15 sensors are marked.
[[nodiscard]] Figure DrawRangeErrors(const SensorErrors& errors, const CalibrationLimits& limits);

/// Where beams point: sideways and in height as they were, with 95 % bars; below, the half widths that remain.
[[nodiscard]] Figure DrawAimErrors(const SensorErrors& errors);

/// How far a placement's readings are from its target.
struct PlacementResidual {
  std::string name;
  double before_mm = std::numeric_limits<double>::quiet_NaN();  ///< RMS with the starting calibration; NaN: to come.
  double after_mm = std::numeric_limits<double>::quiet_NaN();   ///< RMS with the solved one; NaN: not solved yet.
};

/// One bar or two per placement, as many as there are so far: for the report, and while scanning goes on.
[[nodiscard]] Figure DrawPlacementResiduals(const std::vector<PlacementResidual>& placements);
/// Of a solution.
[[nodiscard]] std::vector<PlacementResidual> PlacementResidualsOf(const RingSolution& solution);

/// How much too large each sensor sees a second artefact, mm, with the limit of their RMS: minus its mean residual,
/// measured less expected distance. NaN where unseen.
[[nodiscard]] Figure DrawVerification(const std::vector<double>& sensor_residual_mm, const CalibrationLimits& limits);

/// Contributions to a girth of 900 mm as 95 % half widths, with the limit.
[[nodiscard]] Figure DrawBudget(const std::vector<BudgetLine>& budget, double limit_mm);

/// Residuals unrolled, sensor's direction by height, mean over the placements: before and after with one legend, then
/// after enlarged. Positive: the target was seen too large.
[[nodiscard]] Figure DrawResidualMaps(const RingSolution& solution);

/// x and y of the carriage over the height, less the straight line through them, with the heights where a target stood.
[[nodiscard]] Figure DrawStraightness(const RingSolution& solution);

/// The shapes of round targets, deviations enlarged, with 95 % bands. `names`: one per target of the solution.
[[nodiscard]] Figure DrawRoundness(const RingSolution& solution, const std::vector<std::string>& names);
/// Whether there is anything to show of it: a column that was solved for.
[[nodiscard]] bool HasRoundness(const TargetResult& target);

}  // namespace annulus
