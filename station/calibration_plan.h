#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/calibration_target.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Where a target is to stand, or stood, for one scan.
struct PlannedPlacement {
  std::size_t target = 0;  ///< Index into the plan's targets.
  double x_mm = 0.0;       ///< Where the middle of its axis is, station frame.
  double y_mm = 0.0;
  double tilt_deg = 0.0;                ///< Of its axis against the vertical.
  double tilt_to_deg = 0.0;             ///< Direction that its top leans to, station theta.
  std::optional<double> turn_deg;       ///< Its turn about its own axis, as read off it; nothing: not known.
  std::optional<double> temperature_c;  ///< Of the target; nothing: that of the room.
  std::string scan;                     ///< Recording; "": still to be taken.
  bool verify = false;                  ///< Not used in the solve: the result is held against it.

  /// "2 of 9: cylinder C-17 …" without the number: what somebody has to do.
  [[nodiscard]] std::string Instruction(const CalibrationTarget& of) const;
};

/// What a calibration is made of (docs/formats.md, "Calibration plan").
struct CalibrationPlan {
  std::vector<CalibrationTarget> targets;
  std::vector<PlannedPlacement> placements;
  std::string technician;
  double ambient_c = 20.0;
  double valid_days = 90.0;
};

/// Reads a plan's TOML; `name` is what messages call it. Without placements it gets the usual ones (UsualPlacements).
[[nodiscard]] Result<CalibrationPlan> ParseCalibrationPlan(std::string_view toml, const std::string& name);
/// `target` of `annulus calibrate`: a plan's file, or one target as ParseTarget takes it.
[[nodiscard]] Result<CalibrationPlan> ReadCalibrationPlan(Storage& storage, const std::string& target);

/// The placements that a calibration needs: the first target once in the centre and five times 110 mm off it, tilted by
/// 7 degrees in different directions and turned; every further one three times 90 mm off the centre; those to verify
/// with once.
/// `verify`: one flag per target.
[[nodiscard]] std::vector<PlannedPlacement> UsualPlacements(const std::vector<CalibrationTarget>& targets,
                                                            const std::vector<bool>& verify);

}  // namespace annulus
