#pragma once

#include "base/result.h"
#include "station/body_maps.h"

namespace annulus {

/// Where `after` lies from `before`, mm along the surface's normal to first order: the difference of the radii at the
/// same (theta, z) times the cosine between radius and normal; positive outside. No alignment: a subject that stands
/// elsewhere differs. Main segments.
///
/// Significance as in compare.h: the difference of the radii over its sd, two-sided. The variances of the two scans
/// add: noise, smoothing and detail, sway where known, and the ring's where the models do not name the same
/// calibration. Tests are at the middles of cells of 10 degrees by 10 mm (20 mm on models taller than 600 mm),
/// corrected by Holm's method over all of them, and other places are held to the limit that this leaves; what does not
/// pass is hatched. Without a normal matrix in both nothing is tested, and nothing is hatched but what is inferred.
/// Borrows both.
[[nodiscard]] BodyField DifferenceField(const SurfaceModel& model_before, const MeasuredSurface& before,
                                        const SurfaceModel& model_after, const MeasuredSurface& after);

}  // namespace annulus
