#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "base/calibration_target.h"
#include "base/result.h"
#include "base/ring_calibration.h"
#include "base/storage.h"

namespace annulus {

/// One line of a ring's history of calibrations.
struct CalibrationHistoryEntry {
  std::string hash;              ///< "sha256:…" of that calibration file.
  std::int64_t wall_ns = 0;      ///< When, ns since 1970.
  double common_shift_mm = 0.0;  ///< Mean effective radial change against the one before, at 450 mm, mm.
  double sensor_shift_mm = 0.0;  ///< RMS of the sensors' own changes, mm.
  bool passed = false;

  bool operator==(const CalibrationHistoryEntry&) const = default;
};

/// CAL.json: a calibration with all that is said of it (docs/formats.md).
struct CalibrationFile {
  RingCalibration calibration;  ///< `certificate` is this file's hash once it is written or read.
  std::string program_version;
  std::int64_t wall_ns = 0;           ///< When it was made, ns since 1970.
  std::int64_t valid_until_ns = 0;    ///< ns since 1970.
  std::vector<RecordedBoard> boards;  ///< The ring it belongs to: only with these boards in these places is it used.
  std::vector<CalibrationTarget> targets;
  bool traceable = false;  ///< Every target's radius has a certificate number.
  bool passed = false;     ///< All limits were kept.
  std::string technician;
  double ambient_c = 20.0;
  std::vector<Eigen::Matrix<double, 7, 7>> sensor_covariance;  ///< Of each sensor's unknowns (fitting/ring_unknowns.h).
  std::vector<std::string> unobservable;                       ///< What the readings could not tell.
  std::vector<std::string> recordings;                         ///< Hashes of the scans it was made of.
  std::vector<CalibrationHistoryEntry> history;                ///< The latest is this one's predecessor, last.
};

/// Writes it atomically and puts its hash into `calibration.certificate`.
Status WriteCalibrationFile(Storage& storage, const std::string& path, CalibrationFile& file);

/// Fails on what is no calibration file, of another version, damaged (its hash does not fit), or impossible.
Result<CalibrationFile> ReadCalibrationFile(Storage& storage, const std::string& path);
/// The same of a text; `name` is what messages call it.
Result<CalibrationFile> ParseCalibrationFile(const std::string& text, const std::string& name);

/// Whether the file may be used on a ring with these boards at a time (ns since 1970): fails if it did not pass, has
/// expired, or if a board is another one than was calibrated, naming it.
Status CheckCalibrationFor(const CalibrationFile& file, const std::vector<RecordedBoard>& boards, std::int64_t wall_ns);

/// A name for a ring of these boards: "ring-" and eight hexadecimal digits of their serials in order.
[[nodiscard]] std::string RingSerialOf(const std::vector<RecordedBoard>& boards);

/// "2026-11-29T08:15:00Z" of ns since 1970.
[[nodiscard]] std::string UtcText(std::int64_t wall_ns);

}  // namespace annulus
