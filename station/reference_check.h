#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/reference_record.h"
#include "acquisition/scan.h"
#include "acquisition/swapped_channels.h"
#include "base/calibration_target.h"
#include "base/result.h"
#include "fitting/cylinder_fit.h"

namespace annulus {

/// What a ring must keep to against a known cylinder.
struct ReferenceLimits {
  double common_mm = 0.2;           ///< All sensors together, beyond the target's U, mm.
  double sensor_mm = 0.5;           ///< One sensor, mm.
  double moved_mm = 0.5;            ///< The target's place during the scan, mm.
  std::optional<double> ambient_c;  ///< Of the target; nothing: its certificate's temperature.
};

/// A scan of a cylinder as placements are compared (FindSwappedChannels): means over the levels that see it.
[[nodiscard]] PlacementReadings PlacementOf(const Scan& scan, const CylinderPose& pose);

/// The daily check: fits place, tilt and radius of the cylinder that a scan shows, with the calibration in the scan's
/// header, and holds radius, every sensor and the cylinder's rest against the limits; names drifted and blind sensors,
/// exchanged channels and boards, and a target that moved. Two neighbours that are exchanged can be seen only if the
/// cylinder stands off the axis (a hand's breadth). Fails if the target is none that this check knows, or if no
/// cylinder of about that size is in the scan.
Result<ReferenceRecord> CheckReference(const Scan& scan, const CalibrationTarget& target,
                                       const ReferenceLimits& limits = {});

/// For a terminal: the verdict, the figures, what was found and what to do.
[[nodiscard]] std::string ReferenceText(const ReferenceRecord& record, const ReferenceLimits& limits);

}  // namespace annulus
