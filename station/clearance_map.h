#pragma once

#include <vector>

#include "base/result.h"
#include "modeling/glasses/placement.h"
#include "modeling/measure/measured_surface.h"
#include "station/body_maps.h"

namespace annulus {

/// The gap between a head and a frame that it wears, seen from both.
struct ClearanceMaps {
  /// Distance from each place of the head to the nearest of frame and lenses, mm; negative where a part encloses it,
  /// kClearanceReach where they are farther than that. Borrows the model.
  BodyField head;
  /// Frame parts with their distances from the head, as the fitter measures them (WornPose::Nearest): behind an ear to
  /// the head without its ears. Then the lenses, to the sheet in their rim's plane.
  std::vector<MapMesh> frame;
};

/// The longest distance that is looked for from the head, mm; the scale ends before it.
inline constexpr double kClearanceReach = 35.0;

/// Fails if there is no head to be found, or for a WornFrame made by hand.
[[nodiscard]] Result<ClearanceMaps> ClearanceOf(const SurfaceModel& model, const MeasuredSurface& head,
                                                const WornFrame& worn);

}  // namespace annulus
