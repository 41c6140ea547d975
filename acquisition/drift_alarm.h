#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/drift_history.h"

namespace annulus {

/// When a drift is told.
struct DriftRules {
  double limit_mm = 0.2;            ///< Smaller drifts are not told, mm.
  double significance = 5.0;        ///< A drift is told from so many sd on.
  double scan_limit_mm = 0.25;      ///< The same for what one scan alone says, at its end, mm.
  double scan_significance = 5.0;   ///< The same.
  std::size_t baseline_scans = 10;  ///< Customers after a calibration that make each sensor's baseline, >= 2.
  double body_sigma_mm = 0.04;      ///< sd of what bodies have in common in a sensor's direction, mm.
  double person_sigma_mm = 0.02;    ///< sd of what one body alone has, beyond what its scan shows, mm.
  double wander_sigma_mm = 0.02;    ///< How much a good sensor changes from one customer to the next, mm.
};

/// Against what a sensor has drifted.
enum class DriftSince {
  kBaseline,     ///< The first customers after the calibration.
  kCalibration,  ///< The calibration itself: it was so from the first customer on.
  kWithinScan,   ///< In the newest scan alone.
};
/// As in JSON: "baseline", "calibration", "scan".
[[nodiscard]] const char* DriftSinceName(DriftSince since);

/// A sensor, or a block of them, that reads otherwise than it did.
struct DriftAlarm {
  std::size_t sensor = 0;  ///< The first one.
  std::size_t count = 1;   ///< So many side by side, by the same amount.
  DriftSince since = DriftSince::kBaseline;
  double drift_mm = 0.0;    ///< By how much they read too long, relative to their neighbours.
  double sigma_mm = 0.0;    ///< sd of it.
  double speed_mm_s = 0.0;  ///< Within the newest scan; 0 where it does not matter.
  [[nodiscard]] std::string Text() const;
};

/// One sensor's filtered state.
struct SensorState {
  double offset_mm = std::numeric_limits<double>::quiet_NaN();  ///< Against its neighbours, now.
  double sigma_mm = std::numeric_limits<double>::infinity();
  double baseline_mm = std::numeric_limits<double>::quiet_NaN();  ///< NaN while it is being made.
  double baseline_sigma_mm = std::numeric_limits<double>::infinity();
  double scatter = 1.0;  ///< Variance of its offsets in the scans before the newest over what was expected of it.
};

/// What the history says of the ring now.
struct DriftState {
  std::size_t scans = 0;        ///< Since the calibration.
  bool baseline_ready = false;  ///< Else only drifts against the calibration and within a scan can be told.
  std::vector<SensorState> sensors;
  std::vector<DriftAlarm> alarms;  ///< The largest first.
};

/// Judges a history. Each sensor's offsets go through a Kalman filter (local level, innovations clipped at 4 sd, so
/// that no single customer makes an alarm of the first two kinds); the deviations of all sensors from their baselines
/// and from zero are taken apart into as few drifting sensors, pairs, triples or boards as explain them (matching
/// pursuit with the mean stencils), since a drifting sensor also shifts what is predicted for its neighbours. The
/// newest scan is judged by itself too, offset and trend together. `boards`: first sensor and count of blocks that may
/// drift as one; may be empty.
[[nodiscard]] DriftState JudgeDrift(const DriftHistory& history, const std::vector<RecordedBoard>& boards = {},
                                    const DriftRules& rules = {});

/// The same while a scan is being taken: `so_far` holds its levels up to now. `history` is a copy; nothing is kept.
/// Fails if the scan is of another ring. About 60 ms: may be asked once a second.
Result<DriftState> JudgeScanSoFar(DriftHistory history, const Scan& so_far, const DriftRules& rules = {});

}  // namespace annulus
