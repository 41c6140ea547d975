#pragma once

#include <optional>
#include <string>
#include <vector>

#include "station/calibration_report.h"

namespace annulus {

/// One line of the table of limits.
struct LimitLine {
  enum class Verdict { kPass, kFail, kNotChecked };
  std::string name;               ///< "Radial error common to all sensors" …
  std::string unit;               ///< "mm", "°" or "".
  std::string meaning;            ///< How the numbers are found; a sentence.
  double limit = 0.0;             ///< Of |found| and |left|; both in its unit.
  std::optional<double> found{};  ///< As found; nothing: not known.
  std::optional<double> left{};   ///< As left; nothing: not checked.

  /// Nothing is held against the limit where there is nothing.
  [[nodiscard]] Verdict found_verdict() const { return Of(found); }
  [[nodiscard]] Verdict left_verdict() const { return Of(left); }

 private:
  [[nodiscard]] Verdict Of(const std::optional<double>& value) const;
};

/// Everything against its limit: the five of CalibrationLimits; then the second artefact: its radius against the common
/// limit, |En| against 1, its sensors' residuals against theirs; then the number of findings of grade failure.
[[nodiscard]] std::vector<LimitLine> JudgeCalibration(const CalibrationReport& report);

/// No line fails as left. A calibration that was not verified can pass; its report says so.
[[nodiscard]] bool CalibrationPasses(const CalibrationReport& report);

/// Whether the result is traceable, and sentences that say so or why not.
struct Traceability {
  bool traceable = false;
  std::string statement;
};

/// Traceable only if every target that was scanned for the solve has a certificate number and, where it has a radius,
/// an uncertainty.
[[nodiscard]] Traceability TraceabilityOf(const CalibrationReport& report);

/// "target S-4711", or "target 2" where it has no serial; "target" if there is no other.
[[nodiscard]] std::string TargetName(const CalibrationReport& report, std::size_t index);

/// Errors of the calibration in force before (as found; else of the one that the solve began with), and what is left
/// after the solve, by sensor at 450 mm. Half widths of sensors that were held are 0 or NaN.
struct SensorErrors {
  std::vector<double> before_mm;    ///< Radial, the common part included.
  std::vector<double> after_mm;     ///< Mean residual over all placements, radial; NaN where unseen.
  std::vector<double> half95_mm;    ///< Of the radial error.
  std::vector<double> lateral_deg;  ///< Before, as an angle.
  std::vector<double> lateral_half95_deg;
  std::vector<double> vertical_deg;
  std::vector<double> vertical_half95_deg;
};
[[nodiscard]] SensorErrors SensorErrorsOf(const CalibrationReport& report);

}  // namespace annulus
