#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// What is to be scanned. Sweeps alternate down, up, down …; level k of sweep s is planned at
///
///     z_top - (s mod m) · pitch - k · m · pitch        m = interleave() = speed / (level rate · pitch)
///
/// counted from the top whatever the direction, so m sweeps together have the final pitch. Parked (speed 0): the ring
/// stays at z_top = z_bottom for dwell_s.
struct ScanPlan {
  std::string profile;       ///< Name of a built-in profile, or of one of the configuration.
  double z_top_mm = 0.0;     ///< Highest level.
  double z_bottom_mm = 0.0;  ///< No level is planned below.
  double pitch_mm = 0.0;     ///< Between levels when all sweeps are put together.
  double speed_mm_s = 0.0;   ///< Of the carriage; 0: parked.
  std::uint32_t sweeps = 1;
  double level_rate_hz = 0.0;
  double dwell_s = 0.0;  ///< Parked only: how long.
  bool of_target =
      false;  ///< A calibration target stands there. It need not fill the ring: silent sensors are no fault.

  [[nodiscard]] bool parked() const { return speed_mm_s == 0.0; }
  /// Sweeps that it takes to fill the pitch (m above). Not for parked plans.
  [[nodiscard]] std::uint32_t interleave() const;
  /// Distance between two levels of one sweep, mm.
  [[nodiscard]] double sweep_pitch_mm() const { return parked() ? 0.0 : speed_mm_s / level_rate_hz; }
  /// Height of the highest level of a sweep, mm.
  [[nodiscard]] double SweepTop(std::uint32_t sweep) const;
  /// Levels of a sweep.
  [[nodiscard]] std::uint32_t SweepLevels(std::uint32_t sweep) const;
  /// Levels of all sweeps.
  [[nodiscard]] std::uint32_t TotalLevels() const;
};

/// Room above and below the levels of a sweep for speeding up and slowing down: v^2 / 2a plus 5 mm.
[[nodiscard]] Millimetres RunUp(const ScanPlan& plan, const AxisLimits& limits);

/// A built-in profile: body, torso, head, breath, target, target_fine or check. `subject_height`: entered, or found by
/// FindSubjectTop; without it body and breath take 1.8 m and torso too, while head fails, because it must know where
/// the head is.
Result<ScanPlan> BuiltInPlan(const std::string& profile, std::optional<Millimetres> subject_height);

enum class PlanVerdict { kValid, kAdjusted, kInvalid };

/// A plan held against the machine.
struct PlanCheck {
  PlanVerdict verdict = PlanVerdict::kInvalid;
  ScanPlan plan;                     ///< What can be done; equal to the request when valid, meaningless when invalid.
  std::vector<std::string> reasons;  ///< One sentence each; empty when valid.
};

/// The machine's own limits win: a plan that can be made to fit is adjusted, else it is invalid, with reasons.
[[nodiscard]] PlanCheck ValidatePlan(const ScanPlan& plan, const AxisLimits& axis, const RingLimits& ring);

/// The plan as a JSON object, keys as the members; of_target only if it is true.
[[nodiscard]] std::string PlanJson(const ScanPlan& plan);
/// The plan that PlanJson wrote, to the last bit. Fails on anything else, and on a plan that makes no sense.
Result<ScanPlan> PlanFromJson(const std::string& json);

}  // namespace annulus
