#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/calibration_target.h"
#include "base/result.h"
#include "base/ring_calibration.h"
#include "base/storage.h"
#include "fitting/calibrate_ring.h"

namespace annulus {

/// A target as it was used.
struct ReportTarget {
  CalibrationTarget target;
  double temperature_c = 20.0;  ///< Of the target while it was scanned, degrees Celsius: mean over its placements.
};

/// How wrong the calibration was that was in force before: it less the new one, where each sensor's beam is 450 mm from
/// the sensor. The ring's centre shift and turn are removed, as no reading can show them.
struct AsFound {
  std::string calibration_hash;      ///< Of the calibration that was in force, "sha256:…"; "" for an ideal ring.
  std::string date;                  ///< When it was made, ISO 8601; "" if not known.
  double common_mm = 0.0;            ///< Mean radial error of all sensors; positive: bodies were measured too large.
  std::vector<double> radial_mm;     ///< By sensor: effective radial error, without the common one.
  std::vector<double> lateral_rad;   ///< By sensor: sideways error as an angle; positive as aim_lateral.
  std::vector<double> vertical_rad;  ///< By sensor: error in height as an angle, without the common one.
};

/// `earlier` against `left` at the temperature of the new one, hash and date left empty. Both must have as many
/// sensors.
[[nodiscard]] AsFound AsFoundOf(const RingCalibration& earlier, const RingCalibration& left);

/// A second artefact that took no part in the solve, measured with the new calibration.
struct CalibrationVerification {
  CalibrationTarget target;
  double temperature_c = 20.0;       ///< While it was scanned, degrees Celsius.
  double found_radius_mm = 0.0;      ///< Measured.
  double found_u_mm = 0.0;           ///< Its expanded uncertainty (k = 2), the calibration's own included.
  double certified_radius_mm = 0.0;  ///< At `temperature_c`.
  double certified_u_mm = 0.0;       ///< U (k = 2).
  double residual_rms_mm = 0.0;      ///< RMS over the sensors of each one's mean residual.
  /// By sensor: that mean residual, measured less expected distance; NaN where unseen; may be empty.
  std::vector<double> sensor_residual_mm;

  /// (found - certified) / sqrt(U_found^2 + U_certified^2): within ±1 both agree (ISO/IEC 17043). Infinite if neither
  /// has an uncertainty and both differ.
  [[nodiscard]] double En() const;
};

/// An earlier calibration of the same ring.
struct EarlierCalibration {
  std::string date;  ///< ISO 8601.
  std::string hash;  ///< "sha256:…"
  std::string technician;
  double common_mm = 0.0;  ///< As AsFound, when it was replaced: what it had wrong by then.
  bool passed = false;
};

/// What a calibration is held against.
struct CalibrationLimits {
  double common_mm = 0.2;      ///< 95 % of the radial error common to all sensors, anywhere from 250 to 550 mm.
  double sensor_rms_mm = 0.3;  ///< RMS over the sensors of their own radial error at 450 mm.
  double lateral_deg = 0.05;   ///< RMS over the sensors of the sideways error at 450 mm, as an angle.
  double vertical_deg = 0.2;   ///< Likewise in height.
  double girth_mm = 1.0;       ///< 95 % of a girth of 900 mm.
};

/// All that a calibration's report and certificate say. Times are texts: the report knows no clock.
struct CalibrationReport {
  RingSolution solution;              ///< As left.
  std::vector<ReportTarget> targets;  ///< In the order of solution.targets.
  std::optional<AsFound> as_found;    ///< Nothing: the ring had no calibration before.
  std::optional<CalibrationVerification> verification;
  std::optional<double> ambient_c;          ///< Of the room, degrees Celsius.
  std::string ring_serial;                  ///< Shown as it is, as all texts.
  std::string technician;                   ///< "" shows as not entered.
  std::string date;                         ///< ISO 8601 of the calibration.
  std::string valid_for;                    ///< "90 days"
  std::string next_due;                     ///< ISO 8601.
  std::string program_version;              ///< Of annulus.
  std::string calibration_hash;             ///< "sha256:…" of the file that this report belongs to.
  std::vector<EarlierCalibration> history;  ///< Oldest first, this one not among them.
  CalibrationLimits limits;
};

/// The report as one HTML page that asks for nothing else: plots inside as SVG. Same report, same bytes.
[[nodiscard]] std::string CalibrationReportHtml(const CalibrationReport& report);

/// The same content as a PDF of A4 pages, the certificate first. Same report, same bytes. Fails if a letter of a text
/// that was entered has no font on this machine.
[[nodiscard]] Result<std::vector<std::byte>> CalibrationReportPdf(const CalibrationReport& report);

/// Writes report.html, report.pdf and plots/*.png into a folder, which is made if need be; each file atomically.
Status WriteCalibrationReport(Storage& storage, const std::string& directory, const CalibrationReport& report);

}  // namespace annulus
