#pragma once

#include <array>
#include <optional>

#include "base/result.h"
#include "fitting/placement_bins.h"
#include "fitting/target_shape.h"

namespace annulus {

/// A target with its form in its place. Borrows the target.
struct PlacedTarget {
  const CalibrationTarget& target;
  TargetForm form;
  TargetPose pose;

  [[nodiscard]] std::optional<TargetHit> Meet(const Ray& ray) const { return MeetTarget(target, form, pose, ray); }
};

/// Whether it is of the ring and has numbers that can be used: readings are what recordings say.
[[nodiscard]] bool IsReading(const RingCalibration& ring, const TargetReading& reading);

/// Which of the pose's six numbers (x, y, slope_x, slope_y, turn, z) a kind of target shows; the others keep their
/// values.
[[nodiscard]] std::array<bool, 6> PoseFreedom(CalibrationTarget::Kind kind);

/// Where the target of a scan stands: sections first, then robust least squares of distances with the starting
/// calibration. The nominal form at the scan's temperature, of a plane its thickness too. Fails if it is not there.
[[nodiscard]] Result<PlacedTarget> FindPose(const RingCalibration& start, const CalibrationTarget& target,
                                            const TargetScan& scan);

}  // namespace annulus
